#include "controller/watch/text_chart.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <string_view>

namespace granary::watch {

namespace {

constexpr std::array<std::string_view, 9> kBlocks = {" ", "▁", "▂", "▃", "▄", "▅", "▆", "▇", "█"};
constexpr std::array<std::string_view, 9> kAscii = {" ", ".", ".", ":", ":", "-", "=", "+", "#"};

}  // namespace

std::string bar(double share, int columns, bool unicode) {
  const int width = std::max(1, columns - 2);
  const double filled = std::clamp(std::isfinite(share) ? share : 0.0, 0.0, 1.0) * width;
  std::string text = "[";
  for (int k = 0; k < width; ++k) {
    const bool full = k < std::lround(filled);
    text += unicode ? (full ? "█" : "░") : (full ? "#" : ".");
  }
  return text + "]";
}

std::vector<double> resampled(const std::vector<double>& time, const std::vector<double>& value, int columns) {
  std::vector<double> out(static_cast<std::size_t>(std::max(0, columns)), std::numeric_limits<double>::quiet_NaN());
  if (time.empty() || out.empty()) return out;
  const double from = time.front(), step = (time.back() - from) / static_cast<double>(out.size());
  double last = value.front();
  std::size_t k = 0;
  for (std::size_t x = 0; x < out.size(); ++x) {
    const double until =
        x + 1 == out.size() ? std::numeric_limits<double>::infinity() : from + step * static_cast<double>(x + 1);
    double sum = 0.0;
    int n = 0;
    for (; k < time.size() && time[k] < until; ++k, ++n) sum += last = value[k];
    out[x] = n > 0 ? sum / n : last;
  }
  return out;
}

std::vector<std::string> area(const std::vector<double>& values, double low, double high, int rows, bool unicode) {
  const auto& glyphs = unicode ? kBlocks : kAscii;
  std::vector<std::string> lines(static_cast<std::size_t>(std::max(0, rows)));
  const double span = high > low ? high - low : 1.0;
  for (const double value : values) {
    // A value at the foot still shows: its column is not empty.
    const double share = std::isfinite(value) ? std::clamp((value - low) / span, 0.0, 1.0) : -1.0;
    const long eighths = share < 0.0 ? 0 : std::max(1L, std::lround(share * 8.0 * rows));
    for (int r = 0; r < rows; ++r) {
      const long here = std::clamp(eighths - 8L * (rows - 1 - r), 0L, 8L);
      lines[static_cast<std::size_t>(r)] += glyphs[static_cast<std::size_t>(here)];
    }
  }
  return lines;
}

}  // namespace granary::watch
