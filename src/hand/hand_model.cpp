// SPDX-License-Identifier: MIT
#include "handyar/hand_model.hpp"

namespace handyar {

std::string_view name(Layout layout) noexcept {
  return layout == Layout::thumb_right ? "thumb_right" : "thumb_left";
}

std::string_view name(Face face) noexcept { return face == Face::palm ? "palm" : "back"; }

std::string_view name(Side side) noexcept { return side == Side::left ? "left" : "right"; }

HandModel HandModel::for_layout(Layout wanted) const {
  HandModel m = *this;
  if (wanted == layout) return m;
  m.layout = wanted;
  m.tips_m.row(0) *= -1;
  return m;
}

HandModel average_adult_hand() {
  HandModel m;
  // Shape: a MakeHuman (CC0) adult hand, fingers spread, and the hand the paper's authors shipped
  // with their program (span 179 mm), averaged; size: scaled to the mean adult hand length of
  // 187 mm (ANSUR II 2012: men 193 mm, women 181 mm).
  m.tips_m << 0.0945, 0.0450, 0.0000, -0.0420, -0.0720,  //
      0.0000, 0.0800, 0.0955, 0.0775, 0.0415,            //
      0.0, 0.0, 0.0, 0.0, 0.0;
  // Hands differ, and thumbs are held in many ways: a model as sure of them as a measured one tilts
  // a hand whose thumb stands otherwise until the object on it hovers over the thumb.
  m.tips_sigma_m << 0.006, 0.003, 0.003, 0.003, 0.003,  //
      0.006, 0.003, 0.003, 0.003, 0.003,                //
      0.003, 0.0015, 0.0015, 0.0015, 0.0015;
  m.layout = Layout::thumb_right;
  m.source = HandSource::average_adult;
  return m;
}

}  // namespace handyar
