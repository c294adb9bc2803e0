# SPDX-FileCopyrightText: The latticed authors
# SPDX-License-Identifier: Apache-2.0
#
# Debian's PostgreSQL and Prometheus, for compose.shared.yaml.
ARG RUNTIME_BASE=debian:bookworm-slim

FROM ${RUNTIME_BASE} AS postgres
RUN apt-get update -q && DEBIAN_FRONTEND=noninteractive apt-get install -y -q --no-install-recommends postgresql \
    && rm -rf /var/lib/apt/lists/* && install -d -o postgres -m 0700 /database && install -d -o postgres /run/postgresql
ENV PATH=/usr/lib/postgresql/15/bin:/usr/bin:/bin
USER postgres
STOPSIGNAL SIGINT
# Only containers that mount the folder of the socket reach it, so nobody needs a password.
CMD ["sh", "-ec", "[ -s /database/PG_VERSION ] || initdb -D /database -A trust -U latticed -E UTF8 --locale C; exec postgres -D /database -k /run/postgresql -c listen_addresses="]

FROM ${RUNTIME_BASE} AS prometheus
RUN apt-get update -q && DEBIAN_FRONTEND=noninteractive apt-get install -y -q --no-install-recommends prometheus \
    && rm -rf /var/lib/apt/lists/* && install -d -o prometheus /samples
USER prometheus
EXPOSE 9090
ENTRYPOINT ["prometheus", "--config.file=/etc/latticed/prometheus.yml", "--storage.tsdb.path=/samples"]
