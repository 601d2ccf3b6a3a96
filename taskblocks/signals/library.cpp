// The blocks of this folder.
#include "taskblocks/set.h"
#include "taskblocks/signals/file_logger.h"
#include "taskblocks/signals/log_msg.h"
#include "taskblocks/signals/lookup_table.h"
#include "taskblocks/signals/rate_limiter.h"
#include "taskblocks/signals/recorder.h"
#include "taskblocks/signals/signal_generator.h"

namespace plc::blocks {

PICARD_LINKED_LIBRARY(signals_library, "signals", "1.0.0", LookupTable, RateLimiter, SignalGenerator, Recorder,
                      FileLogger, LogMsg)

}  // namespace plc::blocks
