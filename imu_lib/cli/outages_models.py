"""The filter models that the flags of `imu-lib outages` name."""

from __future__ import annotations

import sys

from imu_lib.cli import common
from imu_lib.errors import InputError
from imu_lib.record import CHANNELS

#: Bias left at switch-on where nobody says: 0.2 deg/s and 20 mg.
TURN_ON = (0.2, 20.0)


def arm(text):
    """The lever arm that --lever-arm states, or None."""
    if text is None:
        return None
    try:
        values = [float(x) for x in text.split(",")]
    except ValueError:
        values = []
    if len(values) != 3 or not all(abs(x) < 1e3 for x in values):
        raise InputError(f"--lever-arm: {text!r} is not X,Y,Z in m, as in 1.2,0.3,-1.")
    return values


def _held(args, arm, base):
    """What the flags hold of the drive, after what the model file does."""
    from imu_lib.drive_effects import DriveEffect

    effects = list(() if base is None else base.drive)
    if args.latency is not None or args.velocity_latency is not None:
        before = {e.name: e for e in effects}.get("gnss_time_offset")
        offset = args.latency
        if offset is None:
            offset = 0.0 if before is None else before["offset"]
        own = {} if args.velocity_latency is None else {"velocity_offset": args.velocity_latency}
        effects.append(DriveEffect("gnss_time_offset", {"offset": offset, **own}))
    if arm is not None:
        effects.append(DriveEffect("lever_arm", {"arm": arm}))
    return tuple(effects)


def models(args, names, drive, arm):
    """The filter models by name: those asked for, and what --static or --model adds."""
    from imu_lib.model import Model
    from imu_lib.navigation import models, variants
    from imu_lib.navigation.filter_model import FilterModel

    base, static, more = None, None, {}
    if args.model:
        base = Model.load(args.model)
        missing = [c for c in CHANNELS if c not in base]
        if missing:
            raise InputError(
                f"{args.model}: the error model has no channel {missing[0]}; a drive needs all "
                "six: `imu-lib characterise RECORD --out DIR` of a record with gyros and "
                "accelerometers writes one that has them"
            )
    effects = _held(args, arm, base)
    options = {"turn_on_sd": _turn_on(args, base)}
    if base is not None:
        name = base.name or "given"
        more[name] = FilterModel.of(base, name=name, **options)
    if args.static:
        from imu_lib.characterise import characterise
        from imu_lib.readers import read_record

        of_text = {} if str(args.static).endswith(".npz") else common.reading_options(args)
        static = read_record(args.static, **of_text)
        print("characterising the static record ...", file=sys.stderr)
        try:
            found = characterise(static).model
        except ValueError as error:
            raise InputError(f"{args.static} can't be characterised: {error}") from None
        more["likelihood"] = FilterModel("likelihood", found, flicker="markov", **options)
        base = base or models.read_off(static, drive.rate)
    if base is None:
        print(
            "note: no --static and no --model: the models are those of the 2013 paper's "
            "3DM-GX3-25, not of this sensor.",
            file=sys.stderr,
        )
    bases = tuple(dict.fromkeys(variants.split(n)[0] for n in names))
    known = tuple(n for n in bases if n not in more)
    made = {
        **models.five(
            base,
            static=static,
            rate=drive.rate,
            names=known,
            causal=args.causal,
            constant=True,
            **options,
        ),
        **more,
    }
    for_all = tuple(k for k in ("scale", "speed") if getattr(args, k))
    for_all += ("road",) if args.road or args.road_sd else ()
    out = {}
    for name in (*names, *(n for n in more if n not in names)):
        base_name, extras = variants.split(name) if name in names else (name, ())
        out[name] = variants.varied(
            made[base_name].with_(effects=effects),
            (*extras, *for_all),
            drive,
            name=name,
            road_sd=args.road_sd or variants.ROAD_SD,
        )
    return out


def _turn_on(args, base):
    from imu_lib.units import DEG, MILLI_G

    stated = None if base is None else base.turn_on
    given = (args.gyro_bias, args.accel_bias)
    usual = tuple(
        v * unit if stated is None else s
        for v, unit, s in zip(TURN_ON, (DEG, MILLI_G), stated or TURN_ON)
    )
    return tuple(u if g is None else g * unit for g, unit, u in zip(given, (DEG, MILLI_G), usual))
