"""A list of two robots that is right, for tests that put mistakes into it."""

from __future__ import annotations

KEY, OTHER = "a" * 40, "b" * 40
LIST = f"""operator_key = "keys/operator.toml"

[[robots]]
name = "robot1"
address = "tcp://192.168.1.21:5555"
public_key = "{KEY}"

[[robots]]
name = "robot2"
address = "tcp://192.168.1.22:5555"
public_key = "{OTHER}"

[poses]
kind = "natnet"
server = "192.168.1.10"
local = "192.168.1.11"
rigid_bodies = [11, 12]
"""
