"""The plain shape: FastAPI, pydantic and the ORM, one commit for each message, on SQLite with our settings.

    python -m benchmarks.ingest.peers.plain PORT DATABASE.db

Endpoint and session are those of FastAPI's and SQLAlchemy's tutorials. An event that is stored already is not
stored again. Screens are shown every event, as in FastAPI's chat example: one after the other. It does less
than the campus: no sessions, no effects, no statuses.
"""

import sys
from typing import Annotated, Any

import uvicorn
from fastapi import FastAPI, WebSocket
from fastapi.concurrency import run_in_threadpool
from pydantic import BaseModel, Field
from sqlalchemy import BigInteger, Engine, String, create_engine, event
from sqlalchemy.orm import DeclarativeBase, Mapped, Session, mapped_column
from starlette.websockets import WebSocketDisconnect


class Base(DeclarativeBase):
    pass


class StoredEvent(Base):
    __tablename__ = "vehicle_events"
    vehicle_id: Mapped[str] = mapped_column(String(64), primary_key=True)
    boot_id: Mapped[str] = mapped_column(String(64), primary_key=True)
    sequence: Mapped[int] = mapped_column(BigInteger, primary_key=True)
    stamp_ns: Mapped[int] = mapped_column(BigInteger)
    body: Mapped[str]


class Reported(BaseModel):
    boot_id: Annotated[str, Field(max_length=64)]
    sequence: Annotated[int, Field(ge=0)]
    stamp_ns: int
    body: dict[str, Any]


class Acknowledged(BaseModel):
    type: str = "events_acknowledged"
    boot_id: str
    next_sequence: int


def open_database(path: str) -> Engine:
    engine = create_engine(f"sqlite:///{path}")

    @event.listens_for(engine, "connect")
    def _prepare(raw: Any, _record: object) -> None:
        for pragma in ("journal_mode=WAL", "synchronous=FULL", "busy_timeout=10000"):
            raw.execute(f"PRAGMA {pragma}").close()

    Base.metadata.create_all(engine)
    return engine


def plain_app(engine: Engine) -> FastAPI:
    app = FastAPI()
    screens: list[WebSocket] = []

    def store(vehicle_id: str, reported: Reported) -> None:
        with Session(engine) as session:
            key = (vehicle_id, reported.boot_id, reported.sequence)
            if session.get(StoredEvent, key) is None:
                session.add(
                    StoredEvent(
                        vehicle_id=vehicle_id,
                        boot_id=reported.boot_id,
                        sequence=reported.sequence,
                        stamp_ns=reported.stamp_ns,
                        body=str(reported.body),
                    )
                )
                session.commit()

    @app.post("/vehicles/{vehicle_id}/events")
    def post_event(vehicle_id: str, reported: Reported) -> Acknowledged:
        store(vehicle_id, reported)
        return Acknowledged(boot_id=reported.boot_id, next_sequence=reported.sequence + 1)

    @app.websocket("/vehicles/{vehicle_id}")
    async def vehicle_socket(websocket: WebSocket, vehicle_id: str) -> None:
        await websocket.accept()
        try:
            while True:
                reported = Reported.model_validate_json(await websocket.receive_text())
                await run_in_threadpool(store, vehicle_id, reported)
                answer = Acknowledged(boot_id=reported.boot_id, next_sequence=reported.sequence + 1)
                await websocket.send_text(answer.model_dump_json())
                for screen in screens:
                    await screen.send_text(reported.model_dump_json())
        except WebSocketDisconnect:
            return

    @app.websocket("/screens")
    async def screen_socket(websocket: WebSocket) -> None:
        await websocket.accept()
        screens.append(websocket)
        try:
            await websocket.receive_text()
        except WebSocketDisconnect:
            screens.remove(websocket)

    return app


if __name__ == "__main__":
    uvicorn.run(
        plain_app(open_database(sys.argv[2])), port=int(sys.argv[1]), log_level="warning", access_log=False
    )
