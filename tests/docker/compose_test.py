#!/usr/bin/env python3
# SPDX-FileCopyrightText: The latticed authors
# SPDX-License-Identifier: Apache-2.0
#
# usage: compose_test.py
# Checks docker/compose.yaml against docker/.env and the Dockerfiles: the services of each profile, and of the GPU
# and proxy services all that can be checked without running them; and compose.shared.yaml against the proxy, Prometheus
# and the server's metrics. container_test.sh runs the CPU service, haproxy_test.sh and shared_test.sh the proxy. Without a yaml module it skips (77), or fails if
# LATTICED_REQUIRE_PYTHON is set.
import os
import re
import sys
from pathlib import Path

try:
    import yaml
except ModuleNotFoundError:
    print("skipped, missing: python3-yaml")
    sys.exit(1 if os.environ.get("LATTICED_REQUIRE_PYTHON") else 77)

DOCKER = Path(__file__).resolve().parent.parent.parent / "docker"


def started(services, profile):
    return [name for name, service in services.items() if profile in service.get("profiles", [profile])]


def published(service):
    """Returns (host address, default host port, container port) of each published port."""
    return [
        re.fullmatch(r"([\d.]+):\$\{LATTICED_\w+_PORT:-(\d+)\}:(\d+)", port).groups()
        for port in service["ports"]
    ]


def exposed(dockerfile):
    return re.search(r"^EXPOSE (.*)", dockerfile, re.M)[1].split()


def check_profiles(services, default_profile):
    assert started(services, default_profile) == ["latticed"]
    assert started(services, "gpu") == ["latticed-gpu"]
    assert started(services, "public") == ["latticed", "proxy"]
    assert services["latticed"]["image"] != services["latticed-gpu"]["image"]


def check_confinement(service, dockerfile, address):
    assert published(service) == [(address, port, port) for port in exposed(dockerfile)]
    assert service["read_only"] and service["cap_drop"] == ["ALL"]
    assert service["security_opt"] == ["no-new-privileges:true"]


def check_build(build, dockerfile):
    assert set(build.get("args", {})) <= set(re.findall(r"^ARG (\w+)", dockerfile, re.M))


def check_gpu(service, dockerfile):
    (device,) = service["deploy"]["resources"]["reservations"]["devices"]
    assert device == {"driver": "nvidia", "count": "all", "capabilities": ["gpu"]}
    assert "NVIDIA_VISIBLE_DEVICES=all NVIDIA_DRIVER_CAPABILITIES=compute,utility" in dockerfile
    arguments = service["build"]["args"]
    assert arguments["LATTICED_CUDA"] == "ON"  # must be quoted in YAML, where ON means true
    devel = re.fullmatch(r"nvidia/cuda:(13\.0\.\d+)-devel-(ubuntu24\.04)", arguments["BUILD_BASE"])
    assert arguments["RUNTIME_BASE"] == "nvidia/cuda:{}-runtime-{}".format(*devel.groups())


def check_proxy(service, dockerfile, server):
    configuration = (DOCKER / "haproxy.cfg").read_text()
    (name,) = service["depends_on"]
    places = re.findall(rf"^  server \w+ {name}:(\d+) .*check port (\d+)", configuration, re.M)
    assert {port for place in places for port in place} == set(exposed(server))
    (bind,) = re.findall(r"^  bind [\d.]+:(\d+) ssl crt (\S+)", configuration, re.M)
    assert [bind[0]] == exposed(dockerfile)
    (volume,) = service["volumes"]
    assert volume.endswith(f":{bind[1]}:ro")


def check_shared():
    services = yaml.safe_load((DOCKER / "compose.shared.yaml").read_text())["services"]
    servers = [name for name, service in services.items() if service["image"] == "latticed:cpu"]
    backends = (DOCKER / "haproxy-servers.cfg").read_text()
    assert re.findall(r"^  server (\w+) \1:50151 ", backends, re.M) == servers
    assert re.findall(r"^  server (\w+) \1:8080 ", backends, re.M) == servers
    for name in servers:
        assert services[name]["environment"]["LATTICED_ADVERTISE"] == name
        assert services[name]["environment"]["LATTICED_STORE"] == "postgres"
    for service in services.values():
        assert service["read_only"] and service["cap_drop"] == ["ALL"]
        assert (DOCKER / service["build"]["dockerfile"].split("/")[-1]).exists()
    published_ports = [port for service in services.values() for port in service.get("ports", [])]
    assert [port.split(":")[0] for port in published_ports] == [
        "0.0.0.0",
        "127.0.0.1",
    ]  # the proxy, Prometheus

    (job,) = yaml.safe_load((DOCKER / "prometheus.yml").read_text())["scrape_configs"]
    assert job["static_configs"][0]["targets"] == [f"{name}:9090" for name in servers]
    (group,) = yaml.safe_load((DOCKER / "alerts.yml").read_text())["groups"]
    shown = (DOCKER.parent / "server/edge/metrics.cc").read_text()
    for rule in group["rules"]:
        for family in re.findall(r"latticed_\w+", rule["expr"]):
            assert f'"{family.removesuffix("_bucket")}"' in shown, family


def main():
    check_shared()
    environment = dict(re.findall(r"^(\w+)=(.*)", (DOCKER / ".env").read_text(), re.M))
    services = yaml.safe_load((DOCKER / "compose.yaml").read_text())["services"]
    check_profiles(services, environment["COMPOSE_PROFILES"])
    dockerfiles = {}
    for name, service in services.items():
        build = service["build"]
        dockerfiles[name] = (DOCKER / build["context"] / build["dockerfile"]).read_text()
        check_confinement(service, dockerfiles[name], "0.0.0.0" if name == "proxy" else "127.0.0.1")
        check_build(build, dockerfiles[name])
    check_gpu(services["latticed-gpu"], dockerfiles["latticed-gpu"])
    check_proxy(services["proxy"], dockerfiles["proxy"], dockerfiles["latticed"])


main()
