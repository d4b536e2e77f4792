// Where and how figures were made: what a report has to say for them to mean anything.
#pragma once

#include <string>

namespace facetsort {

// Processor, threads of the caller's task arena, compiler.
std::string describe_machine();

// Now, in UTC, ISO 8601: "2026-01-31T12:00:00Z".
std::string utc_time();

// The arguments as one line that a shell would split into them again.
std::string quoted_command_line(int argc, const char* const* argv);

}  // namespace facetsort
