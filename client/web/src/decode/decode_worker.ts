// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
export {};
