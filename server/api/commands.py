"""Commands of one actor. One with an idempotency key is carried out once; a repeat gets the first answer."""

import hashlib
import hmac
from collections.abc import Awaitable, Callable
from dataclasses import dataclass
from typing import Annotated, Any, TypeVar

import msgspec
from cryptography.hazmat.primitives.ciphers.aead import AESGCM
from fastapi import Depends, Header, Request
from pydantic import TypeAdapter

from server.api.formats import RideToken
from server.api.security.access import Actor, ChangingOperator, Driver, now_ns
from server.api.services import InjectedServices, Services
from server.domain.record.answers import KeyedRequest
from server.domain.rides.rides import RideSource
from server.usecases.ports.unit_of_work import Transactions, UnitOfWork
from server.usecases.record.answers import AnsweredBefore, answer_once
from server.usecases.record.identity import sha256_of

M = TypeVar("M")
T = TypeVar("T")

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
    """

    transactions: Transactions
    kind: RideSource
    by: str
    account: str
    key: str | None
    request: bytes

    async def transact(self, kind: type[M], work: Callable[[UnitOfWork], M]) -> M:
        """The answer of `work`, of type `kind`, in one transaction. Raises IdempotencyMismatch."""
        return await self.call(kind, lambda transactions: transactions.run(work), lambda answer: answer)

    async def call(
        self, kind: type[M], use_case: Callable[[Transactions], Awaitable[T]], view: Callable[[T], M]
    ) -> M:
        """The view, of type `kind`, of what a use case returns that runs its transactions itself.

        The transaction that succeeds returns what the use case returns. Raises IdempotencyMismatch.
        """
        if self.key is None:
            return view(await use_case(self.transactions))
        key, codec = self.key, _codec(kind)
        request = KeyedRequest(self.account, sha256_of(key), hashlib.sha256(self.request).hexdigest())
        once = _OnceTransactions(
            self.transactions, request, lambda result: _seal(key, request, codec.encode(view(result)))
        )
        try:
            return view(await use_case(once))
        except AnsweredBefore as before:
            answer: M = codec.decode(_unseal(key, request, before.sealed))
            return answer


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


async def _driver_command(
    request: Request, services: InjectedServices, actor: Driver, idempotency_key: IdempotencyKey = None
) -> Command:
    return await _of_actor(request, services, actor, idempotency_key)


async def _operator_command(
    request: Request,
    services: InjectedServices,
    operator: ChangingOperator,
    idempotency_key: IdempotencyKey = None,
) -> Command:
    return await _of_actor(request, services, operator.actor, idempotency_key)


async def _passenger_command(
    request: Request, services: InjectedServices, token: RideToken, idempotency_key: IdempotencyKey = None
) -> Command:
    account = f"passenger:{sha256_of(token)}"
    services.limits.commands.take(account, now_ns(services))
    text = await _text(request)
    return Command(services.transactions, "passenger", "passenger", account, idempotency_key, text)


async def _of_actor(request: Request, services: Services, actor: Actor, key: str | None) -> Command:
    services.limits.commands.take(actor.account, now_ns(services))
    text = await _text(request)
    return Command(services.transactions, actor.kind, actor.name, actor.account, key, text)


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


DriverCommand = Annotated[Command, Depends(_driver_command)]
OperatorCommand = Annotated[Command, Depends(_operator_command)]
PassengerCommand = Annotated[Command, Depends(_passenger_command)]
