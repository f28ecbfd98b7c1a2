// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>

namespace photic {

/// The part of a picture's file name that stands for the receiver `name`: the name itself where that can be one.
///
/// Otherwise what cannot stand in it (slashes, characters that a terminal acts on, bytes that are no UTF-8) is "_", and
/// eight digits made of the whole name follow, so that two receivers never share a file: "a/b" is "a_b-e2480c78", and
/// "a_b" is "a_b". The same goes for names that would be another picture's ("floor_map", "view", "xray_z") and for long
/// ones.
std::string receiverFileName(const std::string& name);

}  // namespace photic
