"""Names of results that changed, and nothing else of them: the kept bits are looked for under the new name.

A key is a regular expression for one or more whole segments of a name such as ``runs/lossy/rest/x_mean``; the value is
what `re.sub` puts there.  They are applied one after the other, also to results that are words (the name of a method).

    RENAMED = {
        "linearisation": "linearization",  # this segment, wherever it stands
        "(devices/.*)/springpot_power": r"\\1/damping_power",  # in one kind only
    }
"""

from __future__ import annotations

RENAMED: dict[str, str] = {
    r"coloured_noise(_\d)?_(power\w*)": r"colored_noise\1_\2",  # a part's usual name is that of its kind
    r"filtered_noise(_\d)?_(power\w*)": r"kanai_tajimi_noise\1_\2",
    r"recorded(_\d)?_(power\w*)": r"recorded_excitation\1_\2",
    r"circuit(_\d)?_(voltage\w*)": r"piezoelectric_circuit\1_\2",
    r"springpot_(power|force_mean|virial)(\w*)": r"damping_\1\2",
    "closure": "memory_closure",
    "linearisation": "linearization",
    # a sensitivity to a number of the paper's problem is one to a number of a part
    r"(sensitivities/.*)/order": r"\1/springpot_order",
    r"(sensitivities/.*)/coefficient": r"\1/springpot_coefficient",
    r"(sensitivities/.*)/intensity": r"\1/white_noise_intensity",
    r"(sensitivities/.*)/restitution": r"\1/barrier_restitution",
    r"(sensitivities/.*)/position": r"\1/barrier_position",
}
