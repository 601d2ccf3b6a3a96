// plc remote URL upload, start, stop: another program for a running PLC.
//
// In: a client, words of the command line. Out: exit codes, sentences. Does not belong here: other calls (remote.cpp).
#pragma once

#include <functional>
#include <nlohmann/json_fwd.hpp>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "engineering/call.h"

namespace plc::tools {

/// Makes a call by its name. Nothing when it was refused, which is said; while `quiet`, that is not said.
using AskServer =
    std::function<std::optional<engineering::Json>(std::string_view call, const engineering::Json& fields, bool quiet)>;

/// `words`: an image, and perhaps the project that is stored with it. The signature is in IMAGE.sig, if that is there.
int remote_upload(const AskServer& ask, const std::string& url, const std::vector<std::string>& words);
/// `words`: "warm" (default) or "cold". Waits until the program runs, or has failed to.
int remote_start(const AskServer& ask, const std::string& url, const std::vector<std::string>& words);
int remote_stop(const AskServer& ask);

}  // namespace plc::tools
