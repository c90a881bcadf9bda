// results.h5 -> report.html: one self-contained page with plots and tables. Needs no live campaign.
// What is in the results: common/results/campaign_results.hpp. How the pictures are made: plotter.hpp, gnuplot.hpp.
#pragma once

#include <filesystem>
#include <string>

#include "common/result.hpp"
#include "common/results/campaign_results.hpp"
#include "controller/report/figures.hpp"
#include "controller/report/plotter.hpp"

namespace granary::report {

/// The page as HTML text. Plots without data are left out and the page says so; every text of the results is escaped.
/// Errors: those of the plotter.
Result<std::string> report_html(const CampaignResults& results, Plotter& plotter);

/// The page's figures, in its order.
std::vector<Figure> figures_of(const CampaignResults& results);

/// Reads the results, draws with gnuplot and writes the page (beside it first, then renamed over it). The results are
/// only read. Errors: results that cannot be read, no gnuplot, a page that cannot be written.
Status write_report(const std::filesystem::path& results_h5, const std::filesystem::path& html);

/// The page's figures as SVG files FOLDER/PREFIXd50.svg. Errors: as above.
Status write_figures(const std::filesystem::path& results_h5, const std::filesystem::path& folder,
                     const std::string& prefix);

}  // namespace granary::report
