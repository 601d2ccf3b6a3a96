// Signals: SIGINT, SIGTERM and SIGHUP end the plant; SIGUSR1 asks for what was measured so far.
//
// In: signals. Out: a plant that is told to stop; what has come, for those who look. Threads: the main one's; handlers
// run on any. Does not belong here: what a stop is, what is printed.
#pragma once

#include "io-drivers/machine/plant.h"

namespace plc::tools {

/// From now on signals are handled; SIGPIPE and SIGXFSZ have no effect.
void handle_signals();
/// The plant that signals stop from now on, also when one has come before; null: none. It must live until then.
void let_signals_stop(io::Plant* plant);
/// Number of the first signal to stop; 0 = none.
int signal_to_stop();
/// Whether that was so long ago that what cannot be printed is to be lost.
bool printing_takes_too_long();
/// Whether SIGUSR1 has come since the last call.
bool take_wish_for_report();

}  // namespace plc::tools
