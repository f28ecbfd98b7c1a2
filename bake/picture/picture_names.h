// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>
#include <vector>

namespace photic {

/// The part of a picture's file name that stands for the receiver `name`: the name itself where that can be one.
///
/// Otherwise what cannot stand in it (slashes, what Windows keeps for itself (< > : " \ | ? *), characters that a
/// terminal acts on, bytes that are no UTF-8) is "_", and eight digits made of the whole name follow, so that two
/// receivers never share a file: "a/b" is "a_b-e2480c78", and "a_b" is "a_b". The same goes for names that would be
/// another picture's ("floor_map", "view", "xray_z"), for long ones, and for those that differ from another of `all` in
/// capital letters alone, which many disks take for one.
///
/// @param all  the names of the scene's receivers; `name` may be among them
std::string receiverFileName(const std::string& name, const std::vector<std::string>& all = {});

}  // namespace photic
