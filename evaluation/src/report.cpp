// SPDX-License-Identifier: MIT
#include "handyar/evaluation/report.hpp"

#include <filesystem>
#include <optional>
#include <utility>

#include "earlier_report.hpp"
#include "figure8.hpp"
#include "handyar/io/error.hpp"
#include "handyar/io/pending_file.hpp"
#include "handyar/io/pose_csv.hpp"
#include "html.hpp"
#include "layout.hpp"
#include "machine.hpp"
#include "page.hpp"

namespace handyar::evaluation {
namespace {

namespace fs = std::filesystem;
using html::escape;

/// All tables of the report in its order, which is that of tables.csv.
class Tables {
 public:
  /// Takes the table in; returns it as HTML, each number with its line in tables.csv.
  std::string add(Table t) {
    const std::string text = html::table(t, next_line_);
    next_line_ += int(t.figures.size());
    tables_.push_back(std::move(t));
    return text;
  }
  void write(const std::string& csv, const std::string& markdown) const {
    write_tables_csv(csv, tables_);
    write_tables_markdown(markdown, tables_);
  }

 private:
  std::vector<Table> tables_;
  int next_line_ = 2;  // after the header
};

std::string head(const RunDescription& run, const std::vector<Analysis>& analyses) {
  const std::pair<const char*, std::string> facts[] = {{"Command", run.command},
                                                       {"Version", "handyar " + run.version},
                                                       {"Built with", describe_build()},
                                                       {"Machine", describe_machine()},
                                                       {"When", describe_now()}};
  std::string h =
      "<h1>handyar evaluation</h1>\n<p>How well a bare hand serves as a marker: the tables "
      "and Figure 8 of Lee and Höllerer, “Handy AR”, ISWC 2007, on the sequences below. "
      "Every number is a row of <code>tables.csv</code> (hold the pointer over it to see "
      "which), every curve a column of <code>errors.csv</code>.</p>\n<dl>";
  for (const auto& [what, value] : facts)
    h += std::string("<dt>") + what + "</dt><dd>" + escape(value) + "</dd>";
  h += "</dl>\n";
  if (analyses.size() < 2) return h;
  h += "<nav>";
  for (const Analysis& a : analyses)
    h += "<a href=\"#" + escape(a.recording.sequence.name) + "\">" +
         escape(a.recording.sequence.name) + "</a>";
  return h + "</nav>\n";
}

std::string facts_of(const Analysis& a) {
  const Sequence& s = a.recording.sequence;
  std::string h = "<dl><dt>Video</dt><dd>" + escape(s.video) + ", " +
                  std::to_string(s.camera.width_px) + "x" + std::to_string(s.camera.height_px) +
                  "</dd><dt>Camera</dt><dd>" + escape(s.origin_of_camera) +
                  "</dd><dt>Hand</dt><dd>" + escape(s.origin_of_hand) + "</dd></dl>\n";
  if (a.unknown.empty()) return h;
  h += "<div class=\"unknown\"><b>What cannot be said, or only with care</b><ul>";
  for (const std::string& line : a.unknown) h += "<li>" + escape(line) + "</li>";
  return h + "</ul></div>\n";
}

std::string section(const Analysis& a, bool open, Tables& tables) {
  const std::string name = escape(a.recording.sequence.name);
  std::string h = std::string("<details") + (open ? " open" : "") + " id=\"" + name +
                  "\"><summary>" + name + "</summary>\n" + facts_of(a);
  h += tables.add(table3(a));
  h += tables.add(table2(a));
  h += html::charts(a);
  h += tables.add(accuracy_table(a));
  h += tables.add(tracking_table(a));
  h += tables.add(motion_table(a));
  h += tables.add(recovery_table(a));
  h += tables.add(view_table(a));
  h += html::pictures(take_pictures(a), a.has_truth());
  return h;
}

void replace(std::string& text, const std::string& place, std::string_view with) {
  const std::size_t at = text.find(place);
  text.replace(at, place.size(), with);
}

std::string page_with(const std::string& body) {
  std::string text(page::kReportHtml);
  replace(text, "{{uplot_style}}", page::kUplotCss);
  replace(text, "{{style}}", page::kReportCss);
  replace(text, "{{uplot_licence}}", page::kUplotLicence);
  replace(text, "{{uplot_script}}", page::kUplotJs);
  replace(text, "{{script}}", page::kReportJs);
  replace(text, "{{body}}", body);
  return text;
}

void write_poses(const std::string& folder, const Analysis& a) {
  io::PoseCsvWriter poses((fs::path(folder) / (a.recording.sequence.name + ".csv")).string());
  const std::vector<TrackResult>& results = a.recording.main_track().results;
  for (std::size_t i = 0; i < results.size(); ++i)
    poses.write(a.recording.frame_index[i], results[i]);
  poses.finish();
}

std::optional<std::string> shorter_truth(const Analysis& a) {
  if (!a.has_truth()) return std::nullopt;
  const std::size_t known = a.recording.sequence.truth->frames.size();
  const std::size_t frames = a.recording.main_track().results.size();
  if (known >= frames) return std::nullopt;
  return a.recording.sequence.name + ": truth.json knows " + std::to_string(known) + " of " +
         std::to_string(frames) + " frames; the others are not judged";
}

}  // namespace

std::vector<std::string> write_report(const std::string& folder, const RunDescription& run,
                                      const std::vector<Analysis>& analyses,
                                      const std::vector<StillResult>& stills) {
  const auto in_folder = [&](const std::string& name) {
    return (fs::path(folder) / name).string();
  };
  remove_earlier_report(folder);
  std::error_code fault;
  fs::create_directories(in_folder("poses"), fault);
  if (fault) throw io::Error(folder, "cannot be written to: " + fault.message());

  std::vector<std::string> notes;
  Tables tables;
  std::string body = head(run, analyses);
  if (!analyses.empty()) {
    body += "<h2>At a glance</h2>\n" + tables.add(robustness_table(analyses));
    body += tables.add(table1(analyses, "all"));
  }
  if (!stills.empty()) {
    body += "<h2>Still pictures</h2>\n" + tables.add(stills_table(stills));
    write_stills_csv(in_folder("stills.csv"), stills);
  }
  if (!analyses.empty()) body += "<h2>Sequence by sequence</h2>\n";
  for (const Analysis& a : analyses) {
    body += section(a, &a == &analyses.front(), tables);
    if (analyses.size() > 1) body += tables.add(table1({&a, 1}, a.recording.sequence.name));
    body += "</details>\n";
    write_poses(in_folder("poses"), a);
    if (const auto note = shorter_truth(a)) notes.push_back(*note);
    if (a.has_board() &&
        !draw_figure8(a, in_folder("figure8-" + a.recording.sequence.name + ".png")))
      notes.push_back("gnuplot could not be run: no PNG of Figure 8 for " +
                      a.recording.sequence.name);
  }
  tables.write(in_folder("tables.csv"), in_folder("tables.md"));
  if (!analyses.empty()) write_errors_csv(in_folder("errors.csv"), analyses);
  io::write_text(in_folder("report.html"), page_with(body));
  return notes;
}

}  // namespace handyar::evaluation
