// What the journal has of parameters that were taken over: a resume goes on with the same.
#pragma once

#include <optional>
#include <vector>

#include "common/json/value.hpp"
#include "common/result.hpp"
#include "estimation/estimator/estimator.hpp"
#include "pilot/journal/journal.hpp"

namespace granary::estimating {

/// {"time_s", "version", "trial", "cost", "values"}
json::Value record_of(const estimation::Fitted& taken, double time);
estimation::Fitted fitted_of(const json::Value& record);

/// The parameters of the final run: decided once ("estimation.final"), `best` where that is still to be done.
/// Errors: there is none; the journal cannot be written.
Result<std::vector<double>> final_values(pilot::Journal& journal, const std::optional<estimation::Fitted>& best,
                                         double time);

}  // namespace granary::estimating
