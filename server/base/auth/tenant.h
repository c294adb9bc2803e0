// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// Tenants: scenes and meshes belong to the tenant of their caller, and do not exist for the others. Each tenant has ids of
// its own. What the server keeps by id, in memory and in a store, it keeps by key:
//
//   tenant/id   of a tenant
//   id          of the default tenant, whose name is empty
//
// No id has a slash. One that a caller sends with a slash gets a key that nothing has, so nobody reaches into another tenant.
//
// Threads  pure functions
#ifndef LATTICED_SERVER_BASE_AUTH_TENANT_H_
#define LATTICED_SERVER_BASE_AUTH_TENANT_H_

#include <string>
#include <string_view>

namespace latticed {

// 1 to 63 of a-z, 0-9 and '-', so that a name is also part of a file's name everywhere.
[[nodiscard]] bool IsTenantName(std::string_view name);

[[nodiscard]] std::string TenantKey(std::string_view tenant, std::string_view id);
// What is before the slash of a key, and what is after it.
[[nodiscard]] std::string_view TenantOf(std::string_view key);
[[nodiscard]] std::string_view IdOf(std::string_view key);

}  // namespace latticed

#endif  // LATTICED_SERVER_BASE_AUTH_TENANT_H_
