"""What Prometheus reads: https://prometheus.io/docs/instrumenting/exposition_formats/"""

from fastapi import APIRouter, Response
from prometheus_client import CONTENT_TYPE_LATEST

from server.api.problems import problems
from server.api.security.access import READER_REFUSALS, MetricsReader
from server.api.services import InjectedServices

router = APIRouter(tags=["health"])


@router.get(
    "/metrics",
    operation_id="get_metrics",
    response_class=Response,
    responses=problems(*READER_REFUSALS)
    | {200: {"content": {"text/plain": {"schema": {"type": "string"}}}, "description": "Text format."}},
)
async def get_metrics(services: InjectedServices, _: MetricsReader) -> Response:
    """Counts and durations of this server. Prometheus sends a bearer token: a developer's, or that of the
    setting metrics_token."""
    return Response(services.measurements.text(), media_type=CONTENT_TYPE_LATEST)
