// The cases that break solvers of population balances: each ends with a bounded error or a clear refusal.
#pragma once

#include <functional>
#include <optional>
#include <string>
#include <vector>

#include "common/json/value.hpp"
#include "pbm_solver/verification/verification_case.hpp"

namespace granary::pbm {

/// The numbers of all classes at the end, and what is to be compared beside them.
struct HardCase {
  std::string name, text;
  std::string reason;     ///< why the bound is what it is
  double l1_bound = 0.0;  ///< of the number, against `fine_tolerance` (0: not compared)
  double fine_tolerance = 0.0;
  NamedErrors bounds;        ///< in magnitude, of `compare`
  bool must_refuse = false;  ///< the right end is exit 20
  std::function<PbmCase()> pbm_case;
  std::function<NamedErrors(const PbmCase&, const ClassGrid&, const Snapshot& end)> compare{};
  /// Given: at half the time a second run goes on from the state of the first, with this changed.
  std::function<void(PbmCase&)> change{};
};

struct HardResult {
  HardCase known;
  int bins = 0;
  double l1_number = 0.0;  ///< NaN: not compared
  NamedErrors errors;
  Drift drift;
  double drift_bound = 0.0;
  double least = 0.0;  ///< most negative value of any field at any output, over the sum of its field
  std::int64_t steps = 0, implicit_steps = 0, rhs_evaluations = 0;
  double cpu = 0.0;  ///< [s]
  std::optional<Error> refusal;
  bool timed_out = false;
  std::vector<std::string> faults() const;  ///< in words; empty: passed
};

std::vector<HardCase> hard_cases();
/// Runs one, for at most 10 s of processor time each run (more without NDEBUG).
HardResult run_hard_case(const HardCase& hard_case);
json::Value to_json(const HardResult& result);

/// granary-pbm verify hard: all of them, or the one of this name, as a table or JSON. Returns the exit code: 2 no such
/// case, 3 one went wrong.
int verify_hard(const std::string& name, bool as_json);

}  // namespace granary::pbm
