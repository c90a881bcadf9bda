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

Status write_figures(const std::filesystem::path& results_h5, const std::filesystem::path& folder,
                     const std::string& prefix) {
  GRANARY_TRY(const CampaignResults results, read_results(results_h5));
  GnuplotPlotter gnuplot;
  return write_figures(figures_of(results), gnuplot, folder, prefix);
}

Status write_figures(const std::vector<Figure>& figures, Plotter& plotter, const std::filesystem::path& folder,
                     const std::string& prefix) {
  std::vector<Plot> plots;
  for (const Figure& figure : figures)
    if (!figure.plot.script.empty()) plots.push_back(figure.plot);
  GRANARY_TRY(const std::vector<std::string> drawings, plotter.draw(plots));
  GRANARY_CHECK(make_folders(folder));
  for (std::size_t i = 0; i < plots.size(); ++i)
    GRANARY_CHECK(write_text_atomically(folder / (prefix + plots[i].id + ".svg"), as_file(drawings[i])));
  return {};
}

}  // namespace granary::report
