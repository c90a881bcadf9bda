// What an estimation found and how it came to it, as plain data: part of CampaignResults, the group /estimation of
// results.h5. All empty where nothing was estimated.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

namespace granary {

struct EstimationSummary {
  struct Parameter {
    std::string name, key;         ///< "aggregation rate", "/pbm/aggregation/rate"
    std::string unit;              ///< SI; "1": none
    double from = 0.0, to = 0.0;   ///< bounds
    double start = 0.0;            ///< the workflow's own value
    double value = 0.0;            ///< estimated
    double low = 0.0, high = 0.0;  ///< 95 % interval; NaN: not known
    bool operator==(const Parameter&) const = default;
  };
  /// One number of a target.
  struct Datum {
    std::string what;  ///< "d50, outlet"
    std::string unit;
    double time = 0.0;          ///< of the process [s]
    double measured = 0.0;      ///< in its unit
    double error = 0.0;         ///< standard deviation
    double fitted = 0.0;        ///< by the best trial
    std::int64_t held_out = 0;  ///< 1: not fitted
    bool operator==(const Datum&) const = default;
  };

  std::vector<Parameter> parameters;             ///< shape (P)
  std::vector<std::vector<double>> correlation;  ///< shape (P, P); NaN: not known
  std::vector<Datum> data;                       ///< shape (Y)
  std::vector<double> time;                      ///< of each evaluation: wall time since the start [s], shape (Q)
  std::vector<double> cost;                      ///< half the sum of squares; NaN: failed, shape (Q)
  std::vector<std::int64_t> version;             ///< of the rates it was made with, from 1, shape (Q)
  std::vector<std::string> adopted_by;           ///< "0003-pbm", shape (A)
  std::vector<double> adopted_time;              ///< wall time [s], shape (A)
  std::vector<std::vector<double>> adopted;      ///< values, shape (A, P)
  std::vector<double> final_time;                ///< of the process, of the final run [s], shape (F)
  std::vector<double> final_d10, final_d50, final_d90;  ///< at the outlet [m], shape (F)
  std::vector<std::string> warnings;                    ///< shape (Z)
  std::string phase;                                    ///< how far it came: search, uncertainty, posterior, done
  double misfit = 0.0;                                  ///< sum of squares over (data - parameters)
  double held_out = 0.0;                                ///< mean square of the held-out residuals; NaN: none
  double used = 0.0;                                    ///< idle core seconds that it worked on [core s]
  double left = 0.0;                                    ///< that nothing worked on [core s]
  double coupled_wall = 0.0;                            ///< wall time of the coupling, without the final run [s]
  bool operator==(const EstimationSummary&) const = default;
};

}  // namespace granary
