/* Calls of an exported law with numbers of any bits, and with sound ones between; every torque is checked. */
#include "short_it.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>

static uint64_t seed = 20161130U;

static uint64_t draw(void)
{
    seed ^= seed << 13;
    seed ^= seed >> 7;
    seed ^= seed << 17;
    return seed;
}

/* Any bits where `wild`, else a number of a robot. */
static short_it_real number(int wild)
{
    short_it_real value;
    const uint64_t bits = draw();
    if (wild) {
        memcpy(&value, &bits, sizeof value);
        return value;
    }
    return (short_it_real)((double)(bits >> 11) / 4503599627370496.0 - 1.0);
}

int main(int argc, char **argv)
{
    static short_it_state state;
    const short_it_parameters *p = short_it_parameters_exported();
    const long calls = argc > 1 ? atol(argv[1]) : 1000;
    long counts[6] = {0, 0, 0, 0, 0, 0};
    short_it_sample sample;
    short_it_setpoint setpoint;
    short_it_real tau[SHORT_IT_NV];
    memset(&sample, 0, sizeof sample);
    short_it_init(p, &state, &sample);
    for (long k = 0; k < calls; ++k) {
        const int chance = (int)(draw() % 40U);
        const short_it_real dt = chance == 1 ? number(1) : (short_it_real)SHORT_IT_PERIOD;
        for (int i = 0; i < SHORT_IT_NV; ++i) {
            sample.q[i] = number(chance == 2);
            sample.v[i] = number(chance == 3);
            sample.tau[i] = number(chance == 4);
            setpoint.q[i] = number(chance == 5);
            setpoint.v[i] = number(chance == 6);
            setpoint.a[i] = number(chance == 7);
        }
        if (draw() % 500U == 0U) {
            short_it_init(p, &state, &sample);
        }
        ++counts[(int)short_it_step(p, &state, &sample, &setpoint, k % 3000 > 2900 ? (short_it_real)0 : dt, tau)];
        for (int i = 0; i < SHORT_IT_NV; ++i) {
            if (!(tau[i] >= -p->torque_limit[i] && tau[i] <= p->torque_limit[i])) {
                printf("call %ld: joint %d gives %g\n", k, i, (double)tau[i]);
                return 1;
            }
        }
    }
    printf("ok=%ld limited=%ld bad_time=%ld bad_input=%ld bad_result=%ld fault=%ld\n", counts[0], counts[1], counts[2],
        counts[3], counts[4], counts[5]);
    return 0;
}
