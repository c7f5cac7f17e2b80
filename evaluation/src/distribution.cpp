// SPDX-License-Identifier: MIT
#include <algorithm>
#include <cmath>
#include <cstdio>

#include "earlier_report.hpp"
#include "handyar/evaluation/footage.hpp"
#include "handyar/evaluation/tables.hpp"
#include "handyar/io/pending_file.hpp"

namespace handyar::evaluation {
namespace {

/// A figure of a sequence; whether less is better decides which tenth is the worst.
struct Column {
  const char* name;
  const char* unit;
  int decimals;
  bool less_is_better;
  double (*value)(const FootageFigures&);
};

double percent(double share) { return 100 * share; }

constexpr Column kColumns[] = {
    {"rightly tracked", "%", 1, false, [](const auto& f) { return f.right_percent(); }},
    {"wrongly tracked", "%", 1, true, [](const auto& f) { return f.wrong_percent(); }},
    {"rotation, median", "deg", 2, true, [](const auto& f) { return f.rotation_deg.median; }},
    {"rotation, 95 %", "deg", 2, true, [](const auto& f) { return f.rotation_deg.p95; }},
    {"translation, median", "%", 2, true,
     [](const auto& f) { return f.translation_percent.median; }},
    {"fingertips, median of the span", "%", 1, true,
     [](const auto& f) { return percent(f.tip_of_span.median); }},
    {"fingers, abduction", "deg", 1, true, [](const auto& f) { return f.abduction_deg.median; }},
    {"fingers, flexion", "deg", 1, true, [](const auto& f) { return f.flexion_deg.median; }},
    {"palm within 8 px", "%", 1, false, [](const auto& f) { return percent(f.palm_within_8px); }},
    {"within the 95 % bound", "%", 1, false,
     [](const auto& f) { return percent(f.nees_within_95); }},
    {"tracking a frame", "ms", 2, true, [](const auto& f) { return f.tracking_ms; }},
    {"searching a frame", "ms", 2, true, [](const auto& f) { return f.searching_ms; }},
};

std::string number(double value, int decimals) {
  if (!std::isfinite(value)) return "";
  char text[32];
  std::snprintf(text, sizeof text, "%.*f", decimals, value);
  return text;
}

using Figures = std::vector<const FootageFigures*>;

std::string row(const Column& c, const Figures& figures) {
  std::vector<double> values;
  for (const FootageFigures* f : figures)
    if (std::isfinite(c.value(*f))) values.push_back(c.value(*f));
  if (values.empty()) return "";
  std::sort(values.begin(), values.end());
  return std::string("| ") + c.name + " (" + c.unit + ") | " +
         number(percentile(values, 50), c.decimals) + " | " +
         number(percentile(values, c.less_is_better ? 90 : 10), c.decimals) + " | " +
         number(c.less_is_better ? values.back() : values.front(), c.decimals) + " |\n";
}

std::string group_table(const std::string& group, const Figures& figures) {
  int open = 0, right = 0, wrong = 0, other = 0, handless = 0, falsely = 0, changes = 0;
  int jumps = 0, right_as_sound = 0, wrong_as_sound = 0, shown_changes = 0;
  std::optional<int> unsound;
  for (const FootageFigures* f : figures) {
    open += f->open_frames;
    right += f->right;
    wrong += f->wrong;
    right_as_sound += f->right_as_sound;
    wrong_as_sound += f->wrong_as_sound;
    other += f->on_other_hand;
    handless += f->handless_frames;
    falsely += f->falsely_tracked;
    changes += f->state_changes;
    shown_changes += f->shown_changes;
    jumps += f->jumps;
    if (f->unsound) unsound = unsound.value_or(0) + *f->unsound;
  }
  std::string text = "## " + group + "\n\nSequences: " + std::to_string(figures.size()) + ". Of " +
                     std::to_string(open) + " frames with an open hand in view, " +
                     std::to_string(right) + " rightly and " + std::to_string(wrong) +
                     " wrongly tracked (" + std::to_string(right_as_sound) + " and " +
                     std::to_string(wrong_as_sound) + " of these not said to be doubtful), " +
                     std::to_string(other) + " on a second hand; " + std::to_string(changes) +
                     " changes of state between them" +
                     (open > 0 ? ", " + number(100.0 * changes / open, 1) + " in a hundred" : "") +
                     "; an object on it comes or goes " + std::to_string(shown_changes) +
                     " times. Of poses shown as sound, " + std::to_string(jumps) +
                     " leap by over a fifth of the distance" +
                     (unsound ? " and " + std::to_string(*unsound) + " are by truth far off" : "") +
                     ". Of " + std::to_string(handless) + " frames without an outstretched hand, " +
                     std::to_string(falsely) +
                     " tracked.\n\n| over sequences | median | worst tenth | worst |\n"
                     "| --- | --: | --: | --: |\n";
  for (const Column& c : kColumns) text += row(c, figures);
  return text + "\n";
}

/// The worse one first: fewer frames as they should be, then the larger error of the pose; last
/// those that cannot be judged.
bool is_worse(const FootageFigures& a, const FootageFigures& b) {
  const auto right = [](const FootageFigures& f) {
    if (f.open_frames) return f.right_percent();
    return f.handless_frames ? 100.0 - 100.0 * f.falsely_tracked / f.handless_frames : 101.0;
  };
  const auto error = [](const FootageFigures& f) {
    return std::isfinite(f.rotation_deg.p95) ? f.rotation_deg.p95 : 0.0;
  };
  return right(a) != right(b) ? right(a) < right(b) : error(a) > error(b);
}

/// What a sequence came to, in a few words.
std::string verdict(const FootageFigures& f) {
  if (f.open_frames) {
    const Summary& r = f.rotation_deg;
    return number(f.right_percent(), 1) + " % rightly tracked" +
           (std::isfinite(r.p95)
                ? ", rotation " + number(r.median, 1) + " / " + number(r.p95, 1) + " deg"
                : "");
  }
  if (f.handless_frames)
    return std::to_string(f.falsely_tracked) + " of " + std::to_string(f.handless_frames) +
           " frames without an outstretched hand tracked";
  return "nothing is known of it";
}

std::string sequences_csv(const std::vector<FootageFigures>& figures) {
  std::string text =
      "group,sequence,frames,open_frames,right,wrong,right_as_sound,wrong_as_sound,on_other_hand,"
      "handless_frames,falsely_tracked,state_changes,shown_changes,jumps,unsound";
  for (const Column& c : kColumns)
    text += "," + csv_field(std::string(c.name) + " (" + c.unit + ")");
  text += "\n";
  for (const FootageFigures& f : figures) {
    text += csv_field(f.group) + "," + csv_field(f.name);
    for (const int n : {f.frames, f.open_frames, f.right, f.wrong, f.right_as_sound,
                        f.wrong_as_sound, f.on_other_hand, f.handless_frames, f.falsely_tracked,
                        f.state_changes, f.shown_changes, f.jumps})
      text += "," + std::to_string(n);
    text += "," + (f.unsound ? std::to_string(*f.unsound) : "");
    for (const Column& c : kColumns) text += "," + csv_number(c.value(f));
    text += "\n";
  }
  return text;
}

}  // namespace

std::string write_distribution(const std::string& folder,
                               const std::vector<FootageFigures>& figures) {
  remove_earlier_report(folder);
  std::map<std::string, Figures> groups;
  for (const FootageFigures& f : figures) groups[f.group].push_back(&f);
  std::string text = "# How the figures are distributed over sequences\n\n";
  for (const auto& [group, of_group] : groups) text += group_table(group, of_group);

  Figures worst;
  for (const FootageFigures& f : figures) worst.push_back(&f);
  std::stable_sort(worst.begin(), worst.end(), [](auto* a, auto* b) { return is_worse(*a, *b); });
  worst.resize(std::min(worst.size(), kWorstShown));
  text += "## The worst\n\n";
  for (std::size_t i = 0; i < worst.size(); ++i) {
    const FootageFigures& f = *worst[i];
    const std::string file = "worst-" + std::to_string(i + 1) + ".jpg";
    io::write_text(folder + "/" + file, {f.worst_jpeg.begin(), f.worst_jpeg.end()});
    text += std::to_string(i + 1) + ". " + f.group + "/" + f.name + ": " + verdict(f) + ". ![" +
            f.worst_caption + "](" + file + ")\n";
  }
  io::write_text(folder + "/sequences.csv", sequences_csv(figures));
  io::write_text(folder + "/distribution.md", text);
  return text;
}

}  // namespace handyar::evaluation
