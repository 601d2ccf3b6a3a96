// Inside engineering/: the rows of each subject, as calls.cpp puts them together.
#pragma once

#include <span>

#include "engineering/call.h"

namespace plc::engineering {

std::span<const Call> target_calls();
std::span<const Call> login_calls();
std::span<const Call> machine_calls();
std::span<const Call> task_calls();
std::span<const Call> variable_calls();
std::span<const Call> force_calls();
std::span<const Call> alarm_calls();
std::span<const Call> history_calls();
std::span<const Call> recording_calls();
std::span<const Call> page_calls();
std::span<const Call> diagram_calls();
std::span<const Call> past_calls();
std::span<const Call> log_calls();
std::span<const Call> program_calls();
std::span<const Call> upload_calls();
std::span<const Call> user_calls();

}  // namespace plc::engineering
