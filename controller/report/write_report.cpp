#include "common/files.hpp"
#include "controller/report/gnuplot.hpp"
#include "controller/report/report.hpp"

namespace granary::report {

Status write_report(const std::filesystem::path& results_h5, const std::filesystem::path& html) {
  GRANARY_TRY(const CampaignResults results, read_results(results_h5));
  GnuplotPlotter gnuplot;
  GRANARY_TRY(const std::string page, report_html(results, gnuplot));
  return write_text_atomically(html, page);
}

}  // namespace granary::report
