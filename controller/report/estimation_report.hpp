// The report's part on an estimation: parameters with intervals, the fit against the data, how it came about.
#pragma once

#include <string>
#include <vector>

#include "common/results/campaign_results.hpp"
#include "controller/report/figures.hpp"

namespace granary::report {

/// Parameters, correlations, data, core seconds; HTML.
std::string estimation_html(const CampaignResults& results);
/// The objective over wall time and over evaluations; the data with the fit and the final run.
std::vector<Figure> estimation_figures(const CampaignResults& results);

}  // namespace granary::report
