"""The sampled closed loop: its exact linear map, where it is stable, and what margins and errors it has.

Takes an arm, M̄ and gains; gives margins, predicted errors and suggested gains. May import `condition`, `controllers`,
`references` and `numerics`.
"""

from asmc_pin.sampled.error_prediction import (
    StepResponse,
    TrackingPrediction,
    drift_error,
    predict_tracking,
    reversal_estimate,
    step_response,
)
from asmc_pin.sampled.linear_map import (
    ClosedLoop,
    closed_loop,
    inertia_ratios,
    modal_radius,
    spectral_radius,
)
from asmc_pin.sampled.loop_analysis import stability
from asmc_pin.sampled.loop_limits import LoopLimits
from asmc_pin.sampled.noise.sensor_model import LoopSensor, loop_sensor
from asmc_pin.sampled.noise.sensor_noise import LoopNoise
from asmc_pin.sampled.proof.loop_certificate import certify_loop
from asmc_pin.sampled.proof.loop_proof import LoopProof
from asmc_pin.sampled.sampled_loop import SampledLoop
from asmc_pin.sampled.stability_report import StabilityReport

__all__ = [
    "ClosedLoop",
    "LoopLimits",
    "LoopNoise",
    "LoopProof",
    "LoopSensor",
    "SampledLoop",
    "StabilityReport",
    "StepResponse",
    "TrackingPrediction",
    "certify_loop",
    "closed_loop",
    "drift_error",
    "inertia_ratios",
    "loop_sensor",
    "modal_radius",
    "predict_tracking",
    "reversal_estimate",
    "spectral_radius",
    "stability",
    "step_response",
]
