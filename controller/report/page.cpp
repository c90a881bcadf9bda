#include "controller/report/page.hpp"

#include <fmt/format.h>

#include <utility>

#include "controller/report/html.hpp"
#include "controller/report/style_text.hpp"

namespace granary::report {

std::string panel(const std::string& html) { return "<div class=\"panel\">" + html + "</div>\n"; }
std::string soft(const std::string& text) { return "<p class=\"soft\">" + escaped(text) + "</p>\n"; }

std::string card(const std::string& value, const std::string& name) {
  return fmt::format("<div class=\"card\"><b>{}</b><span>{}</span></div>\n", escaped(value), escaped(name));
}

namespace {

std::string figure_html(const Figure& figure, const std::string& svg) {
  const std::string title = escaped(figure.title);
  // The picture says to a screen reader what it shows.
  const std::string labelled =
      "<svg role=\"img\" aria-label=\"" + title + "\"" + svg.substr(std::string_view("<svg").size());
  return fmt::format(
      "<figure id=\"{}\"{}>\n<h3>{}</h3>\n<div class=\"plot\">{}</div>\n<figcaption>{}</figcaption>\n</figure>\n",
      figure.plot.id, figure.plot.width > 1000 ? " class=\"wide\"" : "", title, labelled, escaped(figure.caption));
}

/// Takes the drawings of this section's figures from the front of `next`.
std::string section_html(const Section& section, std::vector<std::string>::const_iterator& next) {
  std::string out =
      fmt::format("<section id=\"{}\">\n<h2>{}</h2>\n{}", section.id, escaped(section.title), section.html);
  std::string drawn;
  std::vector<std::pair<std::string, std::string>> left_out;  // reason, the figures' titles
  for (const auto& figure : section.figures) {
    if (!figure.plot.script.empty()) {
      drawn += figure_html(figure, *next++);
    } else if (!left_out.empty() && left_out.back().first == figure.missing) {
      left_out.back().second += ", “" + figure.title + "”";
    } else {
      left_out.emplace_back(figure.missing, "“" + figure.title + "”");
    }
  }
  if (!drawn.empty())
    out += "<div class=\"figures\"" + std::string(section.html.empty() ? "" : " style=\"margin-top:14px\"") + ">\n" +
           drawn + "</div>\n";
  for (const auto& [reason, titles] : left_out) out += soft("Left out: " + titles + ": " + reason + ".");
  return out + "</section>\n";
}

std::string navigation(const std::vector<Section>& sections) {
  std::string out = "<nav>";
  for (const auto& section : sections)
    out += fmt::format("<a href=\"#{}\">{}</a>\n", section.id, escaped(section.short_title));
  return out + "</nav>\n";
}

}  // namespace

Result<std::string> page_html(const Page& page, Plotter& plotter) {
  std::vector<Plot> plots;
  for (const auto& section : page.sections)
    for (const auto& figure : section.figures)
      if (!figure.plot.script.empty()) plots.push_back(figure.plot);
  GRANARY_TRY(const auto drawings, plotter.draw(plots));
  if (drawings.size() != plots.size())
    return Error{fmt::format("the plotter made {} of {} drawings.", drawings.size(), plots.size()), Exit::internal};

  std::string body = page.header + navigation(page.sections) + page.cards;
  auto next = drawings.begin();
  for (const auto& section : page.sections) body += section_html(section, next);

  return "<!doctype html>\n<html lang=\"en\">\n<head>\n<meta charset=\"utf-8\">\n"
         "<meta name=\"viewport\" content=\"width=device-width, initial-scale=1\">\n<meta name=\"generator\" "
         "content=\"Granary\">\n<title>" +
         escaped(page.title) + "</title>\n<style>\n" + std::string(assets::style) +
         "</style>\n</head>\n<body>\n<div class=\"page\">\n" + body + "</div>\n</body>\n</html>\n";
}

}  // namespace granary::report
