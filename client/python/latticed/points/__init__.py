# SPDX-FileCopyrightText: The latticed authors
# SPDX-License-Identifier: Apache-2.0
"""Point sets: points that stay on the server beside a scene, deformed and differentiated."""
