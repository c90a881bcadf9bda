// The whole logic of the coupling: (state, event) -> (state, actions). Pure: no files, no clock, no processes.
// Diagram and reasons: docs/coupling.md. Effects belong to the controller's runner.
#pragma once

#include <vector>

#include "controller/coupling/action.hpp"
#include "controller/coupling/event.hpp"
#include "controller/coupling/settings.hpp"
#include "controller/coupling/state.hpp"

namespace granary::coupling {

struct Step {
  State next;
  std::vector<Action> actions;
};

/// DEM first; a burst ends when its monitor speaks or its program ends; its result is exchanged; the other side goes on
/// from its own last state. Ends steady, at a limit, stopped or failed. An event about an earlier burst or attempt, or
/// one already heard, changes nothing and asks for nothing.
/// Source: the source paper's controller (DEM first, 15 %, both sides restart), with the additions of docs/coupling.md.
Step update(const State& now, const Event& event, const Settings& settings);

}  // namespace granary::coupling
