// SPDX-License-Identifier: MIT
// The command line as its users meet it: the built program is run, and its exit code, its words and
// the files it leaves are looked at.
#pragma once

#include <gtest/gtest.h>
#include <sys/wait.h>

#include <algorithm>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <set>
#include <sstream>
#include <string>

#include "temporary_folder.hpp"

namespace handyar {

namespace fs = std::filesystem;

inline const std::string kData = HANDYAR_DATA_DIR;
inline const std::string kVideo = kData + "/compare/video.mp4";

struct Outcome {
  int code = -1;
  std::string out, err;
};

inline std::string contents(const fs::path& path) {
  std::ifstream stream(path, std::ios::binary);
  std::ostringstream text;
  text << stream.rdbuf();
  return text.str();
}

inline int lines(const std::string& text) {
  return static_cast<int>(std::count(text.begin(), text.end(), '\n'));
}

class CliTest : public testing::Test {
 protected:
  CliTest() {
    fs::create_directories(root_ / "out");
    fs::create_directories(root_ / "in");
  }

  std::string in(const std::string& name) const { return (root_ / "in" / name).string(); }
  std::string out(const std::string& name) const { return (root_ / "out" / name).string(); }
  std::string outputs() const { return " --poses " + out("p.csv") + " --video " + out("v.mp4"); }
  std::set<std::string> left() const {
    std::set<std::string> names;
    for (const auto& entry : fs::directory_iterator(root_ / "out")) {
      names.insert(entry.path().filename().string());
    }
    return names;
  }
  void write(const std::string& name, const std::string& text) const {
    std::ofstream(in(name), std::ios::binary) << text;
  }
  // A file of the sample with one thing changed.
  std::string changed(const std::string& file, const std::string& what,
                      const std::string& by) const {
    std::string text = contents(kData + "/compare/" + file);
    const auto at = text.find(what);
    EXPECT_NE(at, std::string::npos);
    write(file, text.replace(at, what.size(), by));
    return in(file);
  }

  Outcome run(const std::string& arguments, const std::string& environment = "") const {
    const std::string out = (root_ / "stdout").string(), err = (root_ / "stderr").string();
    const std::string config = "XDG_CONFIG_HOME='" + (root_ / "config").string() + "' ";
    const int status = std::system((config + environment + " '" HANDYAR_PROGRAM "' " + arguments +
                                    " >" + out + " 2>" + err + " </dev/null")
                                       .c_str());
    return {WIFEXITED(status) ? WEXITSTATUS(status) : 128 + WTERMSIG(status), contents(out),
            contents(err)};
  }

  // Exit 1, one line that names `subject`, and nothing left behind.
  void expect_refused(const std::string& arguments, const std::string& subject,
                      const std::string& fault, const std::string& command = "track ") const {
    const Outcome r = run(command + arguments);
    EXPECT_EQ(r.code, 1) << arguments;
    EXPECT_EQ(lines(r.err), 1) << r.err;
    EXPECT_EQ(r.err.rfind("handyar: " + subject + ": ", 0), 0u) << r.err;
    EXPECT_NE(r.err.find(fault), std::string::npos) << r.err;
    EXPECT_EQ(r.out, "");
    EXPECT_EQ(left(), std::set<std::string>{}) << arguments;
  }

  const test::TemporaryFolder temporary_;
  const fs::path& root_ = temporary_.path();
};

}  // namespace handyar
