// The frame of a report's page: head, navigation, sections with their figures. What is in them: report.hpp,
// controller/sweep.
#pragma once

#include <string>
#include <vector>

#include "common/result.hpp"
#include "controller/report/figures.hpp"
#include "controller/report/plotter.hpp"

namespace granary::report {

/// A part of the page: what stands above its figures (HTML), and the figures.
struct Section {
  std::string id, title;
  std::string short_title;  ///< in the navigation
  std::string html;
  std::vector<Figure> figures;
};

struct Page {
  std::string title;   ///< of the window, plain text
  std::string header;  ///< HTML
  std::string cards;   ///< HTML, below the navigation
  std::vector<Section> sections;
};

std::string panel(const std::string& html);
std::string soft(const std::string& text);  ///< a remark; plain text
std::string card(const std::string& value, const std::string& name);

/// One self-contained page. Figures without data are left out and the page says so. Errors: those of the plotter.
Result<std::string> page_html(const Page& page, Plotter& plotter);

}  // namespace granary::report
