"""Tiles belong to the learner: the new place, the old one in earlier files, and both at once."""

import msgspec
import pytest

from core.configuration.reading import ConfigurationError
from core.interop.gymnasium.config import GymnasiumConfig, with_encoder
from core.interop.gymnasium.plugin import PLUGIN
from core.learners.encoder_config import TileEncoder
from core.learners.sarsa_config import SarsaConfig
from core.recording.schema import to_plain
from core.session.protocol import DEFAULTS
from core.session.protocol_reading import protocol_from


def test_the_learners_encoder_says_how_many_tiles() -> None:
    asked = with_encoder(GymnasiumConfig(), TileEncoder(tilings=4, tiles=3, largest=2.0))
    assert (asked.tilings, asked.tiles, asked.largest) == (4, 3, 2.0)


@pytest.mark.parametrize("encoder", [None, TileEncoder()])
def test_the_old_place_holds_where_it_was_used(encoder: TileEncoder | None) -> None:
    asked = with_encoder(GymnasiumConfig(tilings=16), encoder)
    assert (asked.tilings, asked.tiles) == (16, 8)


def test_two_places_that_differ_are_refused() -> None:
    learner = SarsaConfig(encoder=TileEncoder(tilings=4))
    with pytest.raises(
        ValueError,
        match=r"\[domain\] tilings, tiles, largest, joint are 16, 8, 3, false, .* 4, 8, 3, false: say",
    ):
        msgspec.structs.replace(PLUGIN.default(), domain=GymnasiumConfig(tilings=16), learner=learner)


def test_new_recordings_hold_the_new_place_and_other_games_nothing_new() -> None:
    plain = to_plain(PLUGIN.default())
    assert plain["learner"]["encoder"] == {"tilings": 8, "tiles": 8, "largest": 3.0, "joint": False}
    assert set(plain["domain"]) == {"type", "env"}
    assert "encoder" not in to_plain(DEFAULTS["keepaway"])["learner"]


def test_the_protocol_of_an_earlier_recording_is_read_with_the_old_place() -> None:
    plain = to_plain(PLUGIN.default())
    del plain["learner"]["encoder"]
    plain["domain"] |= {"tilings": 4, "tiles": 8, "largest": 3.0}
    protocol = protocol_from(plain)
    assert isinstance(protocol.domain, GymnasiumConfig)
    assert isinstance(protocol.learner, SarsaConfig)
    assert with_encoder(protocol.domain, protocol.learner.encoder).tilings == 4


def test_an_old_place_that_the_new_one_contradicts_is_refused_where_a_protocol_is_to_be_run() -> None:
    plain = {
        "domain": {"type": "gymnasium", "joint": True, "tilings": 8},
        "learner": {"type": "sarsa", "encoder": {"joint": False, "tilings": 8}},
    }
    with pytest.raises(ConfigurationError, match=r"\[domain\] joint.* say it in \[learner.encoder\] alone"):
        protocol_from(plain, to_run=True)
    # A header writes the encoder's defaults beside an old place that was used: it is read as it was meant.
    read = protocol_from(plain)
    assert isinstance(read.domain, GymnasiumConfig)
    assert with_encoder(read.domain, TileEncoder()).joint
