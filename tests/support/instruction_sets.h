// Running a piece of a test with each instruction set that the processor has.
#pragma once

#include <gtest/gtest.h>
#include <hwy/targets.h>

namespace facetsort {

// Returns how many there are.
template <typename Body>
int for_each_instruction_set(const Body& body) {
  int tried = 0;
  for (auto remaining = hwy::SupportedTargets(); remaining != 0; remaining &= remaining - 1) {
    const auto target = remaining & ~(remaining - 1);
    SCOPED_TRACE(hwy::TargetName(target));
    hwy::SetSupportedTargetsForTest(target);
    hwy::GetChosenTarget().DeInit();
    body();
    ++tried;
  }
  hwy::SetSupportedTargetsForTest(0);
  hwy::GetChosenTarget().DeInit();
  return tried;
}

}  // namespace facetsort
