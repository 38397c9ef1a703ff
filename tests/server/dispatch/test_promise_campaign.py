"""Ten thousand random events, driven as planned: not one promise is broken. A million: `make soak`."""

from tests.server.dispatch.promise_campaign import run_campaign


def test_no_promise_is_broken_while_travel_times_are_as_planned() -> None:
    campaign = run_campaign(seed=1, events=10_000)
    assert campaign.broken == []
    assert campaign.events == 10_000
    assert min(campaign.taken, campaign.refused, campaign.cancelled, campaign.improved) > 100
    assert campaign.departures > 5
