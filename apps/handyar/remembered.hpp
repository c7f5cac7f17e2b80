// SPDX-License-Identifier: MIT
#pragma once

#include <string>

#include "handyar/camera.hpp"
#include "handyar/hand_model.hpp"

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

/// `given`, or the remembered camera where that is empty. Throws WrongUsage when there is neither.
std::string input_of(const std::string& given);

void remember_input(const std::string& input);
void remember_camera(const Camera& camera);
void remember_hand(const HandModel& hand);
/// All of it, or all but the hand.
void forget(bool hand_too);

}  // namespace handyar::cli
