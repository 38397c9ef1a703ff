"""Commands of one actor. One with an idempotency key is carried out once; a repeat gets the first answer."""

import hashlib
import hmac
from collections.abc import Awaitable, Callable
from dataclasses import dataclass, replace
from typing import Annotated, Any, Protocol, TypeVar, runtime_checkable

import msgspec
from cryptography.hazmat.primitives.ciphers.aead import AESGCM
from fastapi import Depends, Header, Request
from pydantic import TypeAdapter

from server.api.formats import RideToken
from server.api.security.access import Actor, ActorDependency, changing, now_ns
from server.api.security.permissions import (
    ADMINISTER,
    DISPATCH,
    DRAW_MAPS,
    EVACUATE,
    GIVE_ACCESS,
    HANDLE_INCIDENTS,
    MOVE,
    PLACE,
    PUBLISH_MAPS,
    RECORD,
    REGISTER_WEBHOOKS,
    RUN_SERVICE,
    STOP,
    STORE_LOCALIZATION_MAPS,
    WATCH_VIDEO,
)
from server.api.security.request_origin import address_of, operation_of, subject_of, target_of
from server.api.services import InjectedServices
from server.domain.errors import DomainError, StoreFailure
from server.domain.record.answers import KeyedRequest
from server.domain.record.audit import AuditAction, Caller
from server.domain.rides.rides import RideSource
from server.usecases.ports.unit_of_work import Transactions, UnitOfWork
from server.usecases.record import audit
from server.usecases.record.answers import AnsweredBefore, answer_once
from server.usecases.record.identity import sha256_of

M = TypeVar("M")
T = TypeVar("T")

_UNNAMED = AuditAction("")
KEY_CHARACTERS_MIN, KEY_CHARACTERS_MAX = 8, 128
KEY_PATTERN = r"^[\x21-\x7e]+$"

IdempotencyKey = Annotated[
    str | None,
    Header(
        min_length=KEY_CHARACTERS_MIN,
        max_length=KEY_CHARACTERS_MAX,
        pattern=KEY_PATTERN,
        description="Made by the client for each command, best a UUID. A repeat gets the first answer.",
        examples=["6f1d0c1e-2b7a-4f0e-9a34-0d5c2f7be801"],
    ),
]


@dataclass(frozen=True, slots=True)
class Command:
    """A request that changes something.

    by       who it is, for the record; kind: what the rules know of them
    account  whose idempotency keys count
    request  what has to be the same in a repeat
    caller, action  for the audit log; None for passengers, who are not named there
    """

    transactions: Transactions
    kind: RideSource
    by: str
    account: str
    key: str | None
    request: bytes
    caller: Caller | None = None
    action: AuditAction = _UNNAMED

    def about(self, subject: str, detail: str = "") -> "Command":
        """The same, with more for the audit log than the path says. detail names no rider."""
        action = replace(self.action, subject=subject, detail=detail or self.action.detail)
        return replace(self, action=action)

    async def transact(self, kind: type[M], work: Callable[[UnitOfWork], M]) -> M:
        """The answer of `work`, of type `kind`, in one transaction. Raises IdempotencyMismatch."""
        return await self.call(kind, lambda transactions: transactions.run(work), lambda answer: answer)

    async def call(
        self, kind: type[M], use_case: Callable[[Transactions], Awaitable[T]], view: Callable[[T], M]
    ) -> M:
        """The view, of type `kind`, of what a use case returns that runs its transactions itself.

        The transaction that succeeds returns what the use case returns. Raises IdempotencyMismatch.
        """
        try:
            return await self._once(kind, use_case, view)
        except DomainError as error:
            await self._record_refusal(error)
            raise

    async def _once(
        self, kind: type[M], use_case: Callable[[Transactions], Awaitable[T]], view: Callable[[T], M]
    ) -> M:
        transactions: Transactions = self.transactions
        if self.caller is not None:
            transactions = _AuditedTransactions(transactions, self.caller, self.action)
        if self.key is None:
            return view(await use_case(transactions))
        key, codec = self.key, _codec(kind)
        request = KeyedRequest(self.account, sha256_of(key), hashlib.sha256(self.request).hexdigest())
        once = _OnceTransactions(
            transactions, request, lambda result: _seal(key, request, codec.encode(view(result)))
        )
        try:
            return view(await use_case(once))
        except AnsweredBefore as before:
            answer: M = codec.decode(_unseal(key, request, before.sealed))
            return answer

    async def _record_refusal(self, error: DomainError) -> None:
        if self.caller is None or isinstance(error, StoreFailure):
            return
        caller, refused = self.caller, replace(self.action, outcome=error.code)
        await self.transactions.run(lambda uow: audit.append(uow, caller, refused))


@runtime_checkable
class _HasCommandId(Protocol):
    """The answer to a command that goes to a vehicle."""

    command_id: str


@dataclass(frozen=True, slots=True)
class _AuditedTransactions:
    """Transactions that enter in the audit log what they do."""

    inner: Transactions
    caller: Caller
    action: AuditAction

    async def run(self, work: Callable[[UnitOfWork], T]) -> T:
        def audited(uow: UnitOfWork) -> T:
            result = work(uow)
            command_id = result.command_id if isinstance(result, _HasCommandId) else ""
            audit.append(uow, self.caller, replace(self.action, command_id=command_id))
            return result

        return await self.inner.run(audited)

    async def read(self, work: Callable[[UnitOfWork], T]) -> T:
        return await self.inner.read(work)


@dataclass(frozen=True, slots=True)
class _OnceTransactions:
    """Transactions that store their result under the request's key."""

    inner: Transactions
    request: KeyedRequest
    seal: Callable[[Any], bytes]

    async def run(self, work: Callable[[UnitOfWork], T]) -> T:
        return await self.inner.run(lambda uow: answer_once(uow, self.request, work, self.seal))

    async def read(self, work: Callable[[UnitOfWork], T]) -> T:
        return await self.inner.read(work)


@dataclass(frozen=True, slots=True)
class _Codec:
    encode: Callable[[Any], bytes]
    decode: Callable[[bytes], Any]


def _codec(kind: Any) -> _Codec:
    if isinstance(kind, type) and issubclass(kind, msgspec.Struct):
        return _Codec(msgspec.json.encode, lambda data: msgspec.json.decode(data, type=kind))
    adapter: TypeAdapter[Any] = TypeAdapter(kind)
    return _Codec(adapter.dump_json, adapter.validate_json)


# A stored answer may hold a ride's token or boarding code. It is encrypted with the client's key, of which
# only the hash is stored. The nonce is made of the answer, so that no two answers have the same one.
_NONCE_BYTES = 12


def _seal(key: str, request: KeyedRequest, answer: bytes) -> bytes:
    secret = _secret(key, request)
    nonce = hmac.digest(secret, answer, "sha256")[:_NONCE_BYTES]
    return nonce + AESGCM(secret).encrypt(nonce, answer, None)


def _unseal(key: str, request: KeyedRequest, sealed: bytes) -> bytes:
    nonce, text = sealed[:_NONCE_BYTES], sealed[_NONCE_BYTES:]
    return AESGCM(_secret(key, request)).decrypt(nonce, text, None)


def _secret(key: str, request: KeyedRequest) -> bytes:
    text = f"campusloop-answer\n{request.account}\n{request.request_sha256}\n{key}"
    return hashlib.sha256(text.encode()).digest()


def command_of(actor_dependency: ActorDependency) -> Callable[..., Awaitable[Command]]:
    """The dependency that makes the command of an actor who may give it."""

    async def command(
        request: Request,
        services: InjectedServices,
        actor: Actor = Depends(actor_dependency),
        idempotency_key: IdempotencyKey = None,
    ) -> Command:
        services.limits.commands.take(actor.account, now_ns(services))
        text = await _text(request)
        return Command(
            services.transactions,
            actor.kind,
            actor.name,
            actor.account,
            idempotency_key,
            text,
            Caller(actor.kind, actor.name, address_of(request)),
            AuditAction(operation_of(request), subject_of(request), target_of(request)),
        )

    return command


async def _passenger_command(
    request: Request, services: InjectedServices, token: RideToken, idempotency_key: IdempotencyKey = None
) -> Command:
    account = f"passenger:{sha256_of(token)}"
    services.limits.commands.take(account, now_ns(services))
    text = await _text(request)
    return Command(services.transactions, "passenger", "passenger", account, idempotency_key, text)


async def _text(request: Request) -> bytes:
    """What has to be the same in a repeat: method, address and body."""
    target = f"{request.method} {request.url.path}?{request.url.query}\n"
    return target.encode() + await request.body()


def booking_key(developer: Actor | None, key: str | None) -> str | None:
    """What a booking's key is stored as: a hash, since a repeat with the key gets the booking's link.

    A developer's key does not meet anyone else's.
    """
    if key is None:
        return None
    if developer is None:
        return f"passenger:{sha256_of(key)}"
    return f"developer:{sha256_of(f'{developer.account} {key}')}"


# One for each permission: the endpoint that takes it needs that permission.
DispatchCommand = Annotated[Command, Depends(command_of(changing(DISPATCH)))]
RecordCommand = Annotated[Command, Depends(command_of(changing(RECORD)))]
WatchVideoCommand = Annotated[Command, Depends(command_of(changing(WATCH_VIDEO)))]
ServiceCommand = Annotated[Command, Depends(command_of(changing(RUN_SERVICE)))]
IncidentCommand = Annotated[Command, Depends(command_of(changing(HANDLE_INCIDENTS)))]
StopCommand = Annotated[Command, Depends(command_of(changing(STOP)))]
MoveCommand = Annotated[Command, Depends(command_of(changing(MOVE)))]
EvacuationCommand = Annotated[Command, Depends(command_of(changing(EVACUATE)))]
PlaceCommand = Annotated[Command, Depends(command_of(changing(PLACE)))]
DrawCommand = Annotated[Command, Depends(command_of(changing(DRAW_MAPS)))]
StoreLocalizationMapCommand = Annotated[Command, Depends(command_of(changing(STORE_LOCALIZATION_MAPS)))]
PublishCommand = Annotated[Command, Depends(command_of(changing(PUBLISH_MAPS)))]
WebhookCommand = Annotated[Command, Depends(command_of(changing(REGISTER_WEBHOOKS)))]
AdminCommand = Annotated[Command, Depends(command_of(changing(ADMINISTER)))]
AccessCommand = Annotated[Command, Depends(command_of(changing(GIVE_ACCESS)))]
PassengerCommand = Annotated[Command, Depends(_passenger_command)]
