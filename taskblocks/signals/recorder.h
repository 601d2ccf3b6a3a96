// RECORDER: what happened before and after an event, cycle by cycle.
#pragma once

#include <array>
#include <chrono>
#include <cstddef>
#include <cstdint>
#include <vector>

#include "picard/taskblock.h"

namespace plc::blocks {

class Recorder final : public picard::Taskblock {
 public:
  static constexpr std::int32_t kSamples = 4096;
  static constexpr picard::Info info{
      .name = "RECORDER",
      .group = "Signals",
      .summary = "Records up to 4096 samples of four signals around a trigger.",
      .details =
          "A rising edge of ARM empties the record and starts a new one. While ARMED, every EVERY-th execution takes "
          "IN1 "
          "to IN4; the newest PRETRIGGER samples at least stay. A rising edge of TRIGGER makes it TRIGGERED: this "
          "execution is recorded in any case, and SAMPLES - PRETRIGGER samples with it. Then it is DONE and the record "
          "stays until the next ARM. A trigger soon after ARM finds less than PRETRIGGER samples before it; COUNT is "
          "smaller then. An edge of ARM always starts anew, also before the record is done. ARM and TRIGGER of the "
          "same "
          "execution arm first. TRUE in the first execution is an edge.\n\n"
          "Reading: OUT1 to OUT4 are the sample at INDEX, 0 the oldest, COUNT - 1 the newest, and TIME_AT its distance "
          "from the trigger, below 0 before it (from the newest sample while there was no trigger). TRIGGER_AT is the "
          "index of the trigger's sample, -1 without one. VALID is FALSE, and the outputs 0, when there is no such "
          "sample. While it records the oldest samples go, so an index does not stay with its sample.\n\n"
          "All values are recorded as they are, NaN too."};

  picard::Input<double> in1{this, "IN1", "first signal"};
  picard::Input<double> in2{this, "IN2", "second signal"};
  picard::Input<double> in3{this, "IN3", "third signal"};
  picard::Input<double> in4{this, "IN4", "fourth signal"};
  picard::Input<bool> arm{this, "ARM", "rising edge: start a new record"};
  picard::Input<bool> trigger{this, "TRIGGER", "rising edge: the event"};
  picard::Input<std::int32_t> index{this, "INDEX", "sample to be read, 0 is the oldest"};
  picard::Config<std::int32_t> samples{
      this, "SAMPLES", "length of the record", {.lowest = 1, .highest = kSamples, .initial = "1000"}};
  picard::Config<std::int32_t> pretrigger{
      this, "PRETRIGGER", "samples before the trigger", {.lowest = 0, .highest = kSamples - 1, .initial = "100"}};
  picard::Config<std::int32_t> every{
      this, "EVERY", "executions from one sample to the next", {.lowest = 1, .initial = "1"}};
  picard::Output<bool> armed{this, "ARMED", "recording, waiting for the trigger"};
  picard::Output<bool> triggered{this, "TRIGGERED", "the trigger came"};
  picard::Output<bool> done{this, "DONE", "the record is complete"};
  picard::Output<std::int32_t> count{this, "COUNT", "samples in the record"};
  picard::Output<std::int32_t> trigger_at{
      this, "TRIGGER_AT", "index of the trigger's sample, or -1", {.initial = "-1"}};
  picard::Output<bool> valid{this, "VALID", "there is a sample at INDEX"};
  picard::Output<double> out1{this, "OUT1", "first signal at INDEX"};
  picard::Output<double> out2{this, "OUT2", "second signal at INDEX"};
  picard::Output<double> out3{this, "OUT3", "third signal at INDEX"};
  picard::Output<double> out4{this, "OUT4", "fourth signal at INDEX"};
  picard::Output<picard::Time> time_at{this, "TIME_AT", "time from the trigger to the sample at INDEX"};

  void ready() override {
    if (pretrigger >= samples) throw picard::Failure("PRETRIGGER is not below SAMPLES");
    ring_.resize(static_cast<std::size_t>(samples.get()));
  }

  void fire() override {
    const bool arms = arm && !arm_before_;
    const bool triggers = trigger && !trigger_before_;
    arm_before_ = arm;
    trigger_before_ = trigger;
    if (arms) {
      state_ = State::Armed;
      recorded_ = 0;
      skip_ = 0;
    }
    if (state_ == State::Armed && triggers) {
      state_ = State::Triggered;
      trigger_number_ = recorded_;
      left_ = samples - pretrigger;
      skip_ = 0;
    }
    if (state_ == State::Armed || state_ == State::Triggered) record();
    show();
  }

 private:
  enum class State { Idle, Armed, Triggered, Done };
  struct Sample {
    std::array<double, 4> values{};
    std::chrono::nanoseconds at{};
  };

  void record() {
    if (skip_ == 0) {
      ring_[recorded_ % ring_.size()] = {{in1, in2, in3, in4}, now()};
      ++recorded_;
      if (state_ == State::Triggered && --left_ == 0) state_ = State::Done;
    }
    skip_ = skip_ + 1 < every ? skip_ + 1 : 0;
  }

  void show() {
    const std::size_t there = recorded_ < ring_.size() ? recorded_ : ring_.size();
    const std::size_t oldest = recorded_ - there;
    const bool has_trigger = state_ == State::Triggered || state_ == State::Done;
    armed = state_ == State::Armed;
    triggered = has_trigger;
    done = state_ == State::Done;
    count = static_cast<std::int32_t>(there);
    trigger_at = has_trigger ? static_cast<std::int32_t>(trigger_number_ - oldest) : -1;
    valid = index >= 0 && index < count.get();
    const Sample nothing{};
    const Sample& shown = valid.get() ? sample(oldest + static_cast<std::size_t>(index.get())) : nothing;
    out1 = shown.values[0];
    out2 = shown.values[1];
    out3 = shown.values[2];
    out4 = shown.values[3];
    time_at = valid.get() ? shown.at - sample(has_trigger ? trigger_number_ : recorded_ - 1).at : picard::Time(0);
  }

  [[nodiscard]] const Sample& sample(std::size_t number) const { return ring_[number % ring_.size()]; }

  State state_ = State::Idle;
  bool arm_before_ = false;
  bool trigger_before_ = false;
  std::vector<Sample> ring_;        ///< sample n lies at n modulo its size
  std::size_t recorded_ = 0;        ///< samples since ARM
  std::size_t trigger_number_ = 0;  ///< of the trigger's sample, counted like recorded_
  std::int32_t left_ = 0;           ///< samples until the record is complete
  std::int32_t skip_ = 0;           ///< executions since the last sample
};

}  // namespace plc::blocks
