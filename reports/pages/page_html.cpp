#include <algorithm>

#include "reports/kit/text.hpp"
#include "reports/pages/page.hpp"
#include "reports/pages/page_assets.hpp"
#include "reports/pages/page_parts.hpp"

namespace klang::reports::detail {
namespace {

std::string row(const std::string& name, const std::string& value) {
  return value.empty() ? "" : "<tr>" + tag("th", name, "scope=\"row\"") + tag("td", value) + "</tr>\n";
}

std::string input_table(const std::vector<InputFile>& inputs) {
  std::string rows;
  for (const InputFile& input : inputs) {
    rows += "<tr>" + tag("td", escaped(input.path)) +
            number_cell(fixed(static_cast<double>(input.n_bytes), 0), static_cast<double>(input.n_bytes)) +
            tag("td", escaped(input.sha256), "class=\"hash\"") + "</tr>\n";
  }
  return scrolled(
      "<table><thead><tr><th scope=\"col\">Input</th><th scope=\"col\" class=\"n\">Bytes</th><th "
      "scope=\"col\">SHA-256</th></tr></thead><tbody>" +
          rows + "</tbody></table>",
      "Inputs");
}

/// Version, command, options, inputs.
std::string how_it_was_made(const Page& page) {
  const Provenance& made = page.header.provenance;
  std::string times;
  for (const auto& [name, seconds] : page.header.wall_time_s)
    times += (times.empty() ? "" : ", ") + escaped(name) + " " + rounded(seconds, 3) + " s";
  const std::string rows = row("Made by", made.version.empty() ? "" : "klang " + escaped(made.version)) +
                           row("Command", made.command.empty() ? "" : "<code>" + escaped(made.command) + "</code>") +
                           row("Seed", made.command.empty() ? "" : std::to_string(made.seed)) + row("Cost", page.cost) +
                           row("Time", times);
  std::string html = rows.empty() ? "" : "<table><tbody>" + rows + "</tbody></table>\n";
  if (!made.inputs.empty()) html += input_table(made.inputs);
  const std::string& options = made.options.text;
  if (!options.empty() && options != "{}" && options != "null")
    html += more("Options", "<pre>" + escaped(options) + "</pre>");
  return html;
}

std::string download_list(const std::vector<Download>& downloads) {
  std::string files;
  for (const Download& download : downloads) {
    files += "<li><a href=\"" + encoded_path(download.file) + "\">" + escaped(download.file) + "</a> " +
             escaped(download.what) + "</li>\n";
  }
  return files.empty() ? "" : "<ul class=\"files\">" + files + "</ul>";
}

std::string warning_box(const Page& page, const std::vector<std::string>& warnings) {
  std::string items;
  for (const std::string& warning : page.header.warnings) items += tag("li", escaped(warning)) + "\n";
  for (const std::string& warning : warnings) items += tag("li", escaped(warning)) + "\n";
  if (items.empty()) return {};
  return "<aside class=\"warn\" aria-label=\"Warnings\"><h2>To know when reading this page</h2><ul>" + items +
         "</ul></aside>\n";
}

/// The policy makes sure that nothing is ever fetched: all a browser may load is in this file.
std::string document_head(const std::string& title, const std::string& content) {
  return "<!doctype html>\n<html lang=\"en\">\n<head>\n<meta charset=\"utf-8\">\n"
         "<meta http-equiv=\"Content-Security-Policy\" content=\"default-src 'none'; img-src data:; "
         "media-src data:; style-src 'unsafe-inline'; script-src 'unsafe-inline' data:\">\n"
         "<meta name=\"viewport\" content=\"width=device-width,initial-scale=1\">\n<title>" +
         escaped(title) + "</title>\n<style>" + page_css(content) + "</style>\n</head>\n";
}

std::string page_top(const Page& page, const std::vector<std::string>& warnings, const std::string& contents) {
  std::string lead;
  for (const std::string& sentence : page.sentences) lead += tag("p", sentence, "class=\"lead\"") + "\n";
  return "<header class=\"top\"><p class=\"over\">" + page.over + "</p>\n<h1>" + escaped(page.title) +
         "</h1>\n<p class=\"verdict\"><span class=\"pill " + page.verdict.kind + "\">" + escaped(page.verdict.words) +
         "</span><span class=\"how\">" + escaped(page.verdict.details) + "</span></p>\n" + lead + page.key_figures +
         warning_box(page, warnings) + "<nav class=\"toc\" aria-label=\"Contents\"><ol>" + contents +
         "</ol></nav></header>\n";
}

}  // namespace

Verdict status_verdict(const ResultHeader& header) {
  const bool good =
      header.status == "ok" || header.status == "done" || header.status == "converged" || header.status.empty();
  std::string words = header.status.empty() ? "Done" : header.status;
  std::replace(words.begin(), words.end(), '_', ' ');
  words = capitalised(words);
  return {words == "Ok" ? "Analysed" : words, good ? "good" : "bad", header.message.value_or("")};
}

void add_if_there(const std::optional<std::string>& file, const char* what, const ReportFolder& folder,
                  std::vector<Download>& downloads) {
  if (file && !file->empty() && folder.has(*file)) downloads.push_back({*file, what});
}

void add_table(const std::string& name, std::string text, const std::vector<InputFile>& inputs, ReportFolder& folder,
               std::vector<Download>& downloads) {
  const bool taken = folder.has(name) && std::any_of(inputs.begin(), inputs.end(), [&](const InputFile& input) {
                       return std::filesystem::path(input.path).filename() == name;
                     });
  const std::string file = taken ? "report-" + name : name;
  folder.add_file(file, std::move(text));
  downloads.push_back({file, "– SI units"});
}

std::string page_html(const Page& page, const std::vector<std::string>& warnings) {
  std::vector<Section> all = page.sections;
  all.push_back({"provenance", "How it was made", how_it_was_made(page)});
  all.push_back({"files", "Files beside this page", download_list(page.downloads)});
  std::string contents, sections;
  for (const Section& section : all) {
    if (section.html.empty()) continue;
    contents += "<li><a href=\"#" + section.id + "\">" + section.name + "</a></li>";
    sections += "<section id=\"" + section.id + "\"><h2>" + section.name + "</h2>\n" + section.html + "</section>\n";
  }
  return document_head(page.title, sections) + "<body>\n" + page_top(page, warnings, contents) + "<main>\n" + sections +
         "</main>\n<footer>This page is one file and needs no network. " + page.footer +
         "</footer>\n<button type=\"button\" class=\"hush\" data-action=\"stop\">Stop</button>\n" +
         page_scripts(sections) + "</body>\n</html>\n";
}

}  // namespace klang::reports::detail
