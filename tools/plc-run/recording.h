// What plc-run does about recordings: what is kept, where, and what is said of it (docs/guides/replay.md).
//
// In: command line, configuration, a resource that is about to run. Out: a shadow (shadow/shadow.h), or none, and
// sentences. Does not belong here: recording and executing scans (shadow/).
#pragma once

#include <iosfwd>
#include <memory>
#include <optional>
#include <string>

#include "core/result.h"
#include "io-drivers/config/configuration.h"
#include "shadow/shadow.h"
#include "tools/engine.h"

namespace plc::tools {

struct RecordingSettings {
  io::RecordMode mode = io::RecordMode::kOn;
  shadow::ShadowOptions options;
};
/// `given`: --record, which counts before plc.toml: a folder, "off", "on" or "check"; empty = not given. `state`: the
/// state folder, or empty. Replicas run in `engine`, where that can be.
RecordingSettings recording_settings(const std::string& given, const io::Configuration& configuration,
                                     const std::string& state, Engine engine);

/// Null when nothing is recorded; why it cannot be is in `trouble`. Before the tasks start, after their taskblocks did.
std::unique_ptr<shadow::Shadow> start_shadow(runtime::Resource& resource, RecordingSettings settings,
                                             std::uint32_t loop_budget, const std::string& zone,
                                             std::optional<core::Problem>& trouble);

/// At the end, and for --stats: scans, bytes, how far back, what was left out.
void print_recording(const shadow::Shadow& shadow, std::ostream& out);

}  // namespace plc::tools
