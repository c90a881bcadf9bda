// SIGTERM, SIGINT and SIGUSR1 ask a run to stop. The fix granary/guard notices and agrees on a step with all ranks.
#pragma once

namespace granary::dem {

/// Instead of LIGGGHTS' own handlers, which stop each rank at a step of its own.
void install_stop_signals();
bool stop_requested();

}  // namespace granary::dem
