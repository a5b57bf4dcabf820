"""Protobuf descriptors of the declared records: embedded in every file, they let any reader in.

They are built at run time from the declarations in `study.events`, so there is no
``.proto`` file and no compiler that could fall out of step with the code.
"""

from __future__ import annotations

from functools import cache

from google.protobuf import descriptor_pb2

from study.events.fields import Kind, Record, record_types, wire_fields

PACKAGE = "scaled_autonomy"

_Proto = descriptor_pb2.FieldDescriptorProto
_PROTO_TYPES: dict[Kind, tuple[_Proto.Type.ValueType, bool]] = {
    # Kind: the protobuf type, and whether it is repeated.
    "fixed64": (_Proto.TYPE_FIXED64, False),
    "sfixed32": (_Proto.TYPE_SFIXED32, False),
    "double": (_Proto.TYPE_DOUBLE, False),
    "bool": (_Proto.TYPE_BOOL, False),
    "string": (_Proto.TYPE_STRING, False),
    "bytes": (_Proto.TYPE_BYTES, False),
    "floats": (_Proto.TYPE_FLOAT, True),
    "doubles": (_Proto.TYPE_DOUBLE, True),
    "ints": (_Proto.TYPE_SFIXED32, True),
    "strings": (_Proto.TYPE_STRING, True),
}


def message_name(record_type: type[Record]) -> str:
    """Return a record type's full protobuf name: ``scaled_autonomy.Timestep``."""
    return f"{PACKAGE}.{record_type.__name__}"


@cache
def descriptor_set(topic: str) -> bytes:
    """Return the serialized ``FileDescriptorSet`` that describes the records of one topic.

    Scalars are ``optional``: proto3 would otherwise leave out zeros, and the layout of a
    message would depend on its values. Numbers in arrays are packed.
    """
    record_type = record_types()[topic]
    file = descriptor_pb2.FileDescriptorProto(
        name=f"{PACKAGE}/{topic}.proto", package=PACKAGE, syntax="proto3"
    )
    message = file.message_type.add(name=record_type.__name__)
    for name, wire in wire_fields(record_type).items():
        proto_type, repeated = _PROTO_TYPES[wire.kind]
        field = message.field.add(name=name, number=wire.number, type=proto_type)
        if repeated:
            field.label = _Proto.LABEL_REPEATED
        else:
            field.label = _Proto.LABEL_OPTIONAL
            field.proto3_optional = True
            # proto3 expresses presence by a oneof of one member, named so by convention.
            field.oneof_index = len(message.oneof_decl)
            message.oneof_decl.add(name=f"_{name}")
    return descriptor_pb2.FileDescriptorSet(file=[file]).SerializeToString(deterministic=True)


def golden_schema() -> dict[str, dict[str, object]]:
    """Return what no later version may change: topic to message and its numbered fields."""
    return {
        topic: {
            "message": message_name(record_type),
            "fields": {
                name: {"number": wire.number, "kind": wire.kind}
                for name, wire in wire_fields(record_type).items()
            },
        }
        for topic, record_type in record_types().items()
    }
