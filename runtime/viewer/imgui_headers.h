// SPDX-License-Identifier: Apache-2.0
/// Dear ImGui 1.89 to 1.92, as Debian installs it, with its parts for GLFW and OpenGL 3.
#pragma once

#include <imgui/backends/imgui_impl_glfw.h>
#include <imgui/backends/imgui_impl_opengl3.h>
#include <imgui/imgui.h>
