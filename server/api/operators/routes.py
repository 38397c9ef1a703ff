"""Operators, for admins."""

from typing import Annotated

from fastapi import APIRouter, Depends

from server.api.commands import AccessCommand
from server.api.operators.schemas import (
    NewOperator,
    OperatorChange,
    OperatorName,
    OperatorView,
    OperatorWithPassword,
    operator_view,
)
from server.api.paging import ListLimit, Page, paged
from server.api.problems import problems
from server.api.security.access import (
    LOOKING_REFUSALS,
    OPERATOR_REFUSALS,
    SECOND_FACTOR_REFUSALS,
    Actor,
    looking,
)
from server.api.security.permissions import ADMINISTER
from server.api.services import InjectedServices, Services
from server.domain.errors import LastAdmin, NameTaken, OperatorUnknown, PasswordInSettings
from server.domain.record.identity import Operator
from server.usecases.ports.unit_of_work import UnitOfWork
from server.usecases.record.operators import operators, second_factors

router = APIRouter(prefix="/operators", tags=["operators"])

_CHANGE = (*OPERATOR_REFUSALS, *SECOND_FACTOR_REFUSALS)


@router.get("", operation_id="list_operators", responses=paged(*LOOKING_REFUSALS))
async def list_operators(
    services: InjectedServices,
    _: Annotated[Actor, Depends(looking(ADMINISTER))],
    page: Page,
    limit: ListLimit = None,
) -> list[OperatorView]:
    """By name, those that are disabled included."""

    def work(uow: UnitOfWork) -> list[OperatorView]:
        owners = uow.second_factors.owners()
        return [operator_view(one, owners) for one in uow.identity.operators()]

    return page.cut(await services.transactions.read(work), limit, lambda one: (one.name,))


@router.post("", operation_id="create_operator", status_code=201, responses=problems(NameTaken, *_CHANGE))
async def create_operator(
    body: NewOperator, services: InjectedServices, command: AccessCommand
) -> OperatorWithPassword:
    """With an initial password, which opens nothing but the choice of another one."""
    password, password_hash = await _initial(services)

    def work(uow: UnitOfWork) -> OperatorWithPassword:
        made = operators.create(uow, body.name, body.roles, password_hash, command.by)
        return _with_password(uow, made, password)

    about = command.about(body.name, f"roles {' '.join(sorted(body.roles))}")
    return await about.transact(OperatorWithPassword, work)


@router.put(
    "/{name}",
    operation_id="change_operator",
    responses=problems(OperatorUnknown, LastAdmin, *_CHANGE),
)
async def change_operator(name: OperatorName, body: OperatorChange, command: AccessCommand) -> OperatorView:
    """Takes effect at once. A disabled operator is signed out everywhere."""

    def work(uow: UnitOfWork) -> OperatorView:
        changed = operators.change(uow, name, body.roles, disabled=body.disabled, by=command.by)
        return operator_view(changed, uow.second_factors.owners())

    state = "disabled" if body.disabled else "enabled"
    about = command.about(name, f"{state}, roles {' '.join(sorted(body.roles))}")
    return await about.transact(OperatorView, work)


@router.post(
    "/{name}/password",
    operation_id="reset_operator_password",
    responses=problems(OperatorUnknown, PasswordInSettings, *_CHANGE),
)
async def reset_operator_password(
    name: OperatorName, services: InjectedServices, command: AccessCommand
) -> OperatorWithPassword:
    """An initial password again. The operator is signed out everywhere."""
    settings = services.settings
    if settings.operator_password and name == settings.operator_name:
        raise PasswordInSettings("this password is the server's setting operator_password; change it there")
    password, password_hash = await _initial(services)

    def work(uow: UnitOfWork) -> OperatorWithPassword:
        return _with_password(uow, operators.reset_password(uow, name, password_hash, command.by), password)

    return await command.transact(OperatorWithPassword, work)


@router.delete(
    "/{name}/second-factor",
    operation_id="reset_operator_second_factor",
    responses=problems(OperatorUnknown, *_CHANGE),
)
async def reset_operator_second_factor(name: OperatorName, command: AccessCommand) -> OperatorView:
    """For one who has lost the authenticator and the recovery codes."""

    def work(uow: UnitOfWork) -> OperatorView:
        operator = operators.operator_named(uow, name)
        second_factors.remove(uow, operator, command.by)
        return operator_view(operator, uow.second_factors.owners())

    return await command.transact(OperatorView, work)


async def _initial(services: Services) -> tuple[str, str]:
    """A password and its hash."""
    made = await services.transactions.read(operators.initial_password)
    async with services.limits.password_checks:
        return made.password, await services.offload.run(made.hashed)


def _with_password(uow: UnitOfWork, operator: Operator, password: str) -> OperatorWithPassword:
    view = operator_view(operator, uow.second_factors.owners())
    return OperatorWithPassword(**view.model_dump(), initial_password=password)
