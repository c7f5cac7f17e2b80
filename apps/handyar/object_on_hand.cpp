// SPDX-License-Identifier: MIT
#include "object_on_hand.hpp"

#include <algorithm>

namespace handyar::cli {

ObjectOnHand::ObjectOnHand(const std::string& model, double size_m, Attachment where)
    : models_{model}, size_m_(size_m), where_(where) {
  for (const char* const other : {"teapot", "bunny", ""})
    if (model != other) models_.push_back(other);
  take(0);
}

void ObjectOnHand::next() { take((current_ + 1) % models_.size()); }

void ObjectOnHand::take(std::size_t which) {
  current_ = which;
  const std::string& model = models_[which];
  overlay_ = model.empty() ? nullptr
                           : std::make_unique<render::HandOverlay>(render::find_model(model),
                                                                   size_m_, where_);
}

}  // namespace handyar::cli
