// SPDX-License-Identifier: MIT
#pragma once

#include <string>

namespace handyar::cli {

/// What `handyar setup` keeps for the commands to which nothing else is given.
struct Remembered {
  std::string input;        ///< a camera's path or name; empty: none
  std::string camera_file;  ///< empty: none
  std::string hand_file;    ///< empty: none
};

/// The folder it is kept in: handyar in $XDG_CONFIG_HOME, or in ~/.config. Throws io::Error when
/// there is neither.
std::string config_folder();

/// Nothing where there is no such folder.
Remembered remembered();

void remember_input(const std::string& input);
/// Checked, and copied into the folder.
void remember_camera(const std::string& file);
void remember_hand(const std::string& file);
void forget();

}  // namespace handyar::cli
