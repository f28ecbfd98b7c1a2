// SPDX-License-Identifier: Apache-2.0
/// OpenVDB 10 to 13: grids and their files. It takes compilers some twenty seconds: include it where it is needed
/// alone.
#pragma once

#include <openvdb/openvdb.h>

#include <openvdb/io/Archive.h>
#include <openvdb/io/File.h>
