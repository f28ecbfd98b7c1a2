# SPDX-License-Identifier: GPL-3.0-or-later
"""Node trees: how to read them, the three groups that look a light volume up, and materials wrapped with them."""
