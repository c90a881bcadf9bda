#include "controller/estimation/adoption.hpp"

namespace granary::estimating {

constexpr const char* kFinal = "estimation.final";

json::Value record_of(const estimation::Fitted& taken, double time) {
  return json::Value::object({{"time_s", time},
                              {"version", taken.version},
                              {"trial", static_cast<std::int64_t>(taken.trial)},
                              {"cost", taken.cost},
                              {"values", taken.values}});
}

estimation::Fitted fitted_of(const json::Value& record) {
  return {record.numbers("values"), static_cast<int>(record.integer_or("version", 0)),
          static_cast<long>(record.integer_or("trial", 0)), record.number_or("cost", 0.0)};
}

Result<std::vector<double>> final_values(pilot::Journal& journal, const std::optional<estimation::Fitted>& best,
                                         double time) {
  if (const auto written = journal.records(kFinal); !written.empty()) return fitted_of(written.back().payload).values;
  if (!best) return Error{"too few evaluations came to their end: there is no estimate."};
  GRANARY_CHECK(journal.append(kFinal, record_of(*best, time)));
  return best->values;
}

}  // namespace granary::estimating
