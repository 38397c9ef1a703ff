"""Operators as admins see and change them."""

from datetime import datetime
from typing import Annotated

from fastapi import Path
from pydantic import BaseModel, ConfigDict, Field
from pydantic.config import JsonDict

from server.api.formats import Name
from server.domain.record.identity import Operator, Role

# That of the settings may be any text.
OperatorName = Annotated[
    str, Path(min_length=1, max_length=64, pattern=r"^[^\x00-\x1f/]+$", examples=["ann"])
]
OPERATOR_EXAMPLE: JsonDict = {
    "name": "ann",
    "roles": ["dispatcher", "viewer"],
    "disabled": False,
    "second_factor": True,
    "password_change_needed": False,
    "created_at": "2026-09-01T08:14:31Z",
}


class NewOperator(BaseModel):
    model_config = ConfigDict(
        extra="forbid", json_schema_extra={"example": {"name": "ann", "roles": ["dispatcher"]}}
    )

    name: Name
    roles: set[Role] = Field(description="viewer is part of every operator's.")


class OperatorChange(BaseModel):
    model_config = ConfigDict(
        extra="forbid", json_schema_extra={"example": {"roles": ["dispatcher", "safety"], "disabled": False}}
    )

    roles: set[Role]
    disabled: bool = False


class OperatorView(BaseModel):
    model_config = ConfigDict(json_schema_extra={"example": OPERATOR_EXAMPLE})

    name: str
    roles: list[Role]
    disabled: bool
    second_factor: bool
    password_change_needed: bool
    created_at: datetime


class OperatorWithPassword(OperatorView):
    """The password is shown this once, and must be changed at the first sign-in."""

    model_config = ConfigDict(
        json_schema_extra={
            "example": OPERATOR_EXAMPLE
            | {"password_change_needed": True, "initial_password": "Zk3v7bX0aY5wQ9eR2tU6pA"}
        }
    )

    initial_password: str


def operator_view(operator: Operator, owners: frozenset[str]) -> OperatorView:
    """owners: ids of the operators with a second factor."""
    return OperatorView(
        name=operator.name,
        roles=sorted(operator.roles),
        disabled=operator.disabled_at is not None,
        second_factor=operator.operator_id in owners,
        password_change_needed=operator.initial_until is not None,
        created_at=operator.created_at,
    )
