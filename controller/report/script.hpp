// The gnuplot a figure is made of: quoted texts, data blocks, colours, and plots of lines over a common axis.
// What is drawn: figures.hpp. Who runs it: gnuplot.hpp.
#pragma once

#include <string>
#include <string_view>
#include <vector>

namespace granary::report {

/// A text as gnuplot takes it: 'it''s'. Line breaks become blanks, so that no text can end its command.
std::string text_literal(std::string_view text);

/// The first `most` characters (not bytes), with "…" if there were more: a long legend leaves no room for the plot.
std::string shortened(std::string_view text, std::size_t most = 24);

/// Colours by what they stand for. All are told apart with any colour vision (Okabe and Ito 2008; viridis).
std::string_view kind_colour(std::string_view task_kind);
std::string_view category_colour(std::size_t i);  ///< bodies, materials: no order
std::string sequence_colour(std::size_t i,
                            std::size_t n);  ///< compartments, bursts, times: dark to light in their order

/// A power of ten that brings the largest of `values` between 1 and 1000 when divided by it, and how it is written in
/// an axis title: "10⁸ ". Plain (1, "") between 0.1 and 9999.
struct Scale {
  double factor = 1.0;
  std::string prefix;
};
Scale scale_for(const std::vector<const std::vector<double>*>& values);

/// Metres as µm, or as mm from 1 mm on.
struct LengthUnit {
  double metres = 1e-6;
  std::string name = "µm";
};
LengthUnit length_unit_for(double largest_metres);

/// A named data block: one line a row, NaN where a number is not finite; a blank line, which breaks lines, before each
/// row of `breaks`.
std::string data_block(std::string_view name, const std::vector<std::vector<double>>& columns,
                       const std::vector<std::size_t>& breaks = {});

bool has_numbers(const std::vector<double>& values);  ///< one at least is finite
/// Column j of rows; NaN where a row is too short.
std::vector<double> column_of(const std::vector<std::vector<double>>& rows, std::size_t j);
std::vector<double> divided(std::vector<double> values, double by);

struct Line {
  std::string title;  ///< "": not in the legend
  std::string colour;
  std::vector<double> y;
  bool dashed = false;
};

/// A shaded region between two curves.
struct Band {
  std::string title, colour;
  std::vector<double> low, high;
};

/// A vertical line with a short text on top.
struct Mark {
  double x = 0.0;
  std::string text;
};

struct LinePlot {
  std::string x_title, y_title;
  std::vector<double> x;
  std::vector<std::size_t> breaks;  ///< rows where the lines begin anew
  std::vector<Line> lines;
  std::vector<Band> bands;
  std::vector<Mark> marks;
  bool log_x = false;
  bool from_zero = true;  ///< the y axis begins at 0
  bool with_points = false;
};

/// Leaves out the rows at both ends where no line has more than a 500th of its largest value.
void trim_to_curves(LinePlot& plot);

/// Commands that draw it; empty if no line has a number.
std::string line_plot_script(const LinePlot& plot);

}  // namespace granary::report
