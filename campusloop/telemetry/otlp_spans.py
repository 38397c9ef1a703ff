"""Spans sent to a collector of traces by OTLP over HTTP (extra `tracing`), in the background of a process."""

import os
from collections.abc import Mapping
from dataclasses import dataclass
from importlib.util import find_spec
from typing import Any

from contract.tracing import NO_SPANS, Span, Spans, SpanSource

# OpenTelemetry's own names. The exporter reads further ones: headers, certificate, time-out.
ENDPOINTS = ("OTEL_EXPORTER_OTLP_TRACES_ENDPOINT", "OTEL_EXPORTER_OTLP_ENDPOINT")


class TracingUnavailable(Exception):
    """Traces are asked for, and what sends them is not installed."""


@dataclass(frozen=True, slots=True)
class OtlpSource:
    """Of processes whose environment names a collector."""

    def open(self, process: str) -> Spans | None:
        return OtlpSpans(process)


def span_source(environment: Mapping[str, str] = os.environ) -> SpanSource:
    """Traces if the environment names a collector, else none. Raises TracingUnavailable."""
    named = [name for name in ENDPOINTS if environment.get(name)]
    if not named:
        return NO_SPANS
    if find_spec("opentelemetry") is None or find_spec("opentelemetry.sdk") is None:
        raise TracingUnavailable(f"{named[0]} is set; install what sends traces (make tracing), or unset it")
    return OtlpSource()


class OtlpSpans:
    """`add` puts a span into a queue, which a thread sends every few seconds; a full queue loses spans."""

    def __init__(self, process: str) -> None:
        from opentelemetry.exporter.otlp.proto.http.trace_exporter import OTLPSpanExporter
        from opentelemetry.sdk.resources import Resource
        from opentelemetry.sdk.trace.export import BatchSpanProcessor

        self._resource = Resource.create({"service.name": "campusloop", "service.instance.id": process})
        self._processor: Any = BatchSpanProcessor(OTLPSpanExporter())

    def add(self, span: Span) -> None:
        from opentelemetry.sdk.trace import ReadableSpan

        parent = _context(span.trace_id, span.parent_id) if span.parent_id else None
        self._processor.on_end(
            ReadableSpan(
                name=span.name,
                context=_context(span.trace_id, span.span_id),
                parent=parent,
                resource=self._resource,
                attributes={f"campusloop.{name}": value for name, value in span.attributes.items()},
                start_time=span.begin_ns,
                end_time=span.end_ns,
            )
        )

    def close(self) -> None:
        self._processor.shutdown()


def _context(trace_id: str, span_id: str) -> Any:
    from opentelemetry.trace import SpanContext, TraceFlags

    flags = TraceFlags(TraceFlags.SAMPLED)
    return SpanContext(int(trace_id, 16), int(span_id, 16), is_remote=False, trace_flags=flags)
