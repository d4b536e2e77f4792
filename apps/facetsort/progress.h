// How far a long run is, for who watches it.
#pragma once

#include <algorithm>
#include <chrono>
#include <string>

namespace facetsort {

// One line on standard error that is written over again, with an estimate of the time left; nothing at all where
// standard error is not a terminal. The line is gone when this object is.
class Progress {
 public:
  // `work`: all that is to be done, in any unit that time is about proportional to.
  explicit Progress(double work);
  Progress(const Progress&) = delete;
  Progress& operator=(const Progress&) = delete;
  ~Progress();

  void show(const std::string& step);
  void add(double work) { done_ += work; }
  // So much is done in all; less than before changes nothing.
  void reach(double work) { done_ = std::max(done_, work); }

 private:
  std::chrono::steady_clock::time_point begin_ = std::chrono::steady_clock::now();
  double work_, done_ = 0;
  bool is_terminal_;
};

}  // namespace facetsort
