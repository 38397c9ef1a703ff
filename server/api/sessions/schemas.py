"""Operators signing in."""

from datetime import datetime

from pydantic import BaseModel, ConfigDict, Field

from server.domain.record.identity import Role


class Credentials(BaseModel):
    model_config = ConfigDict(
        extra="forbid",
        json_schema_extra={"example": {"name": "operator", "password": "correct horse battery"}},
    )

    name: str = Field(min_length=1, max_length=64, pattern=r"^[^\x00-\x1f]+$")
    password: str = Field(min_length=1, max_length=256)


class NewPassword(BaseModel):
    """password: the present one."""

    model_config = ConfigDict(
        extra="forbid",
        json_schema_extra={
            "example": {"password": "Zk3v7bX0aY5wQ9eR2tU6pA", "new_password": "correct horse battery"}
        },
    )

    password: str = Field(min_length=1, max_length=256)
    new_password: str = Field(min_length=12, max_length=256)


class SessionView(BaseModel):
    """The signed-in operator. Send csrf_token in the header X-CSRF-Token with every change."""

    model_config = ConfigDict(
        json_schema_extra={
            "example": {
                "name": "operator",
                "roles": ["dispatcher", "viewer"],
                "csrf_token": "3HqkW9dYx0m2u7aT",
                "expires_at": "2026-09-01T20:14:31Z",
                "password_change_needed": False,
                "second_factor": True,
                "second_factor_required": False,
                "second_factor_until": "2026-09-01T16:14:31Z",
            }
        }
    )

    name: str
    roles: list[Role]
    csrf_token: str
    expires_at: datetime
    password_change_needed: bool = Field(description="Nothing else works until it is changed.")
    second_factor: bool = Field(description="The operator has one.")
    second_factor_required: bool = Field(description="By the settings, to set a vehicle in motion.")
    second_factor_until: datetime | None = Field(
        description="When it has to be checked again; null: it must be checked first."
    )


class Password(BaseModel):
    model_config = ConfigDict(
        extra="forbid", json_schema_extra={"example": {"password": "correct horse battery"}}
    )

    password: str = Field(min_length=1, max_length=256)


class Code(BaseModel):
    """Six digits of an authenticator, or a recovery code."""

    model_config = ConfigDict(extra="forbid", json_schema_extra={"example": {"code": "492039"}})

    code: str = Field(pattern=r"^[A-Za-z0-9_-]{6,64}$")


class NewSecondFactorView(BaseModel):
    """What an authenticator app reads. Shown once."""

    model_config = ConfigDict(
        json_schema_extra={
            "example": {
                "secret": "JBSWY3DPEHPK3PXPJBSWY3DPEHPK3PXP",
                "uri": "otpauth://totp/Campusloop:operator?secret=JBSWY3DPEHPK3PXPJBSWY3DPEHPK3PXP",
                "qr_svg": "<svg xmlns='http://www.w3.org/2000/svg'/>",
            }
        }
    )

    secret: str = Field(description="In base32, to type by hand.")
    uri: str
    qr_svg: str = Field(description="The URI as a QR code: an SVG picture.")


class RecoveryCodes(BaseModel):
    """Each works once instead of a code of the authenticator. Shown once."""

    model_config = ConfigDict(json_schema_extra={"example": {"recovery_codes": ["c1XxR2n9kQ0sT7uVbYwZ3a"]}})

    recovery_codes: list[str]
