// SPDX-License-Identifier: MIT
#pragma once

namespace handyar {

/// Adds up what the stages take, where the user gave a clock.
class StageClock {
 public:
  explicit StageClock(double (*now_s)()) : now_s_(now_s), start_s_(now()) {}
  template <class Stage>
  auto time(double& total_ms, const Stage& stage) const {
    const double start_s = now();
    struct AddOnReturn {
      const StageClock& clock;
      double start_s, &total_ms;
      ~AddOnReturn() { total_ms += 1e3 * (clock.now() - start_s); }
    } add{*this, start_s, total_ms};
    return stage();
  }
  double total_ms() const { return 1e3 * (now() - start_s_); }

 private:
  double now() const { return now_s_ != nullptr ? now_s_() : 0.0; }
  double (*now_s_)();
  double start_s_;
};

}  // namespace handyar
