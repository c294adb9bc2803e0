# SPDX-FileCopyrightText: The latticed authors
# SPDX-License-Identifier: Apache-2.0
#
# Debian's HAProxy with haproxy.cfg. The profile "public" of compose.yaml, and compose.shared.yaml, run it and mount the
# certificate.
ARG RUNTIME_BASE=debian:bookworm-slim

FROM ${RUNTIME_BASE}
RUN apt-get update -q && DEBIAN_FRONTEND=noninteractive apt-get install -y -q --no-install-recommends haproxy \
    && rm -rf /var/lib/apt/lists/*
COPY docker/haproxy.cfg docker/haproxy-shared.cfg docker/haproxy-servers.cfg /etc/haproxy/
RUN touch /etc/haproxy/owners.map
EXPOSE 443
USER 65532:65532
STOPSIGNAL SIGUSR1
ENTRYPOINT ["haproxy", "-db", "-f", "/etc/haproxy/haproxy.cfg"]
