# SPDX-FileCopyrightText: The latticed authors
# SPDX-License-Identifier: Apache-2.0
"""Patches as a stream: the plan, the edge bytes of an update, and the surface made of both. See patches.proto."""
