/* Random frames, valid and damaged, inputs, silence and time, against laws that are true for any host:
 *
 *   - the count is that of RESET, plus or minus one for each step output
 *   - steps are output only in RUN and BRAKE, and in a dry run none has an edge
 *   - the driver is never on while an emergency stop is active, is switched on only in IDLE, and not in a dry run
 *   - each frame gets an answer
 *
 *     fuzz SEED FRAMES
 *
 * Ends with status 1 at the first violation, and prints the law and the number of frames.
 */
#include <inttypes.h>
#include <stdio.h>
#include <string.h>

#include "answers.h"
#include "bytes.h"
#include "config.h"
#include "hal.h"
#include "inputs.h"
#include "line.h"
#include "outputs.h"
#include "queue.h"
#include "reflexes.h"
#include "rounds.h"
#include "state.h"
#include "stop_ramp.h"

static uint64_t seed, frames, steps, edges, taken, times_on;
static int32_t position;
static uint8_t was_on, was_dry;

static uint32_t chance(uint32_t below)
{
    seed ^= seed << 13;
    seed ^= seed >> 7;
    seed ^= seed << 17;
    return (uint32_t)((seed >> 20) % below);
}

#define LAW(holds)                                                                                                     \
    do {                                                                                                               \
        if (!(holds)) {                                                                                                \
            fprintf(stderr, "after %" PRIu64 " frames, state %d: not %s\n", frames, state, #holds);                    \
            exit(1);                                                                                                   \
        }                                                                                                              \
    } while (0)

static uint8_t is_on(void)
{
    return pc.drives_enable && pc.enable == !(config.polarity & POLARITY_ENABLE_LOW);
}

static void check_laws(void)
{
    LAW(position_now() == position);
    LAW(state <= STATE_BOOT);
    LAW(queued <= SLOTS);
    LAW(pc.match == NEVER || state == STATE_RUN || state == STATE_BRAKE);
    LAW(!is_on() || !is_estop_active());
    if (is_on() && !was_on) {
        times_on++;
        LAW(state == STATE_IDLE);
        LAW(!is_dry());
    }
    was_on = is_on();
    was_dry = is_dry();
}

static void stepped(void)
{
    LAW(state == STATE_RUN || state == STATE_BRAKE);
    LAW(!was_dry || pc.is_dry);
    position = (int32_t)((uint32_t)position + (down ? UINT32_MAX : 1));
    steps++;
    edges += !pc.is_dry;
}

static void pass(uint64_t ticks)
{
    uint64_t until = pc.now + ticks, matches = 0;

    while (pc.match <= until) {
        pc_run(pc.match, stepped);
        check_laws();
        if (matches++ > 3000) { /* and the rest of the time is skipped */
            until = pc.now;
            break;
        }
    }
    pc_run(until, stepped);
}

/* -------------------------------------------------------------------------------------------------- frames of a host */
static uint8_t *record_at(uint8_t *to)
{
    static uint32_t pace = 2000;
    uint8_t is_down = (uint8_t)chance(2);

    if (!chance(4))
        pace = 300 + chance(3000);
    if (!chance(6)) {
        *to++ = (uint8_t)(RECORD_PAUSE | is_down | (chance(3) ? 0 : RECORD_REST));
        to = put32(put16(to, 0), 1000 + chance(5000));
        return put32(put16(to, 0), 0);
    }
    *to++ = (uint8_t)(is_down | (chance(4) ? 0 : RECORD_HALF) | (chance(4) ? 0 : RECORD_RAMP_LEFT));
    to = put32(put16(to, (uint16_t)(1 + chance(20))), pace);
    to = put16(to, (uint16_t)chance(65536));
    return put32(to, to[-9] & RECORD_RAMP_LEFT ? chance(200) : chance(3) ? 0 : chance(4000000) - 2000000);
}

static uint8_t say(uint8_t kind, uint8_t *payload)
{
    uint8_t *to = payload, n;

    switch (kind) {
    case FRAME_PUSH:
        for (n = (uint8_t)(1 + chance(RECORDS_MOST)); n; n--)
            to = record_at(to);
        break;
    case FRAME_START:
        to = put32(to, (uint32_t)pc.now + 2000 + chance(20000) - (chance(20) ? 0 : 1u << 28));
        break;
    case FRAME_CONFIG:
        to = put32(put32(to, 2000 + chance(30000)), chance(3) ? 0 : 20000 + chance(100000));
        *to++ = (uint8_t)chance(4);
        *to++ = (uint8_t)chance(64);
        *to++ = (uint8_t)chance(64);
        *to++ = (uint8_t)(chance(5) ? DRIVER_ENABLE : chance(4));
        *to++ = (uint8_t)chance(3);
        to = put16(to, (uint16_t)(chance(2) ? chance(4) : chance(65536)));
        *to++ = (uint8_t)chance(16);
        *to++ = (uint8_t)(chance(5) << 4 | chance(5));
        for (n = 0; n < INPUTS; n++)
            *to++ = (uint8_t)chance(5);
        for (n = 0; n < 8; n++)
            *to++ = (uint8_t)chance(16);
        *to++ = (uint8_t)chance(8);
        break;
    case FRAME_STOP:
        *to++ = (uint8_t)chance(2);
        break;
    case FRAME_TAIL:
        *to++ = (uint8_t)(chance(3) ? 0 : chance(6));
        for (n = (uint8_t)(1 + chance(ENTRIES_MOST)), kind = 0; n; n--)
            to = put16(put32(to, (kind += 20) * 30000u), (uint16_t)(1 + chance(9)));
        break;
    case FRAME_RESET:
        *to++ = (uint8_t)chance(8);
        to = put32(to, chance(4) ? chance(100000) : 0x7FFFFFFF - chance(100));
        break;
    case FRAME_OUTPUTS:
        *to++ = (uint8_t)chance(32);
        *to++ = (uint8_t)(ENABLE | chance(16));
        break;
    case FRAME_REPEAT:
        *to++ = (uint8_t)chance(256);
        break;
    case FRAME_CHECK:
        to = put16(put16(to, (uint16_t)chance(3)), (uint16_t)(200 + chance(100)));
        break;
    }
    return (uint8_t)(to - payload);
}

/* Put a frame on the line; return whether it is valid. */
static uint8_t receive(uint8_t kind, uint8_t number, const uint8_t *payload, uint8_t length)
{
    uint8_t plain[2 + 128 + 2], from = 0, i, total = (uint8_t)(length + 4), *to = pc.received;
    uint8_t is_sound = chance(30) != 0;
    uint16_t crc = 0xFFFF;

    plain[0] = number;
    plain[1] = kind;
    memcpy(plain + 2, payload, length);
    for (i = 0; i < length + 2; i++)
        crc = hal_crc(crc, plain[i]);
    put16(plain + i, (uint16_t)~crc);
    while (from <= total) {
        uint8_t zero = from;

        while (zero < total && plain[zero])
            zero++;
        *to++ = (uint8_t)(zero - from + 1);
        while (from < zero)
            *to++ = plain[from++];
        from++;
    }
    *to++ = 0;
    if (!is_sound)
        pc.received[chance((uint32_t)(to - pc.received))] ^= (uint8_t)(1 << chance(8));
    pc.received_tail = 0;
    pc.received_head = (size_t)(to - pc.received);
    return is_sound;
}

/* Build the next frame of a plausible host, or occasionally a random one. */
static uint8_t next_kind(void)
{
    static const uint8_t often[] = {FRAME_PUSH, FRAME_PUSH, FRAME_PUSH, FRAME_START, FRAME_OUTPUTS, FRAME_TAIL, FRAME_ASK};

    if (!chance(4))
        return (uint8_t)chance(chance(50) ? FRAME_CHECK + 1u : 256u);
    if (state == STATE_BOOT)
        return FRAME_CONFIG;
    if (state == STATE_HALT)
        return chance(4) ? FRAME_RESET : FRAME_CONFIG;
    return often[chance(sizeof often)];
}

static void send_one(void)
{
    uint8_t payload[128], kind = next_kind(), length, i;
    uint8_t number = (uint8_t)(chance(50) ? wanted : chance(256)), is_sound;
    size_t sent = pc.sent_length;

    length = say(kind, payload);
    if (!chance(20)) { /* random content */
        length = (uint8_t)chance(75);
        for (i = 0; i < length; i++)
            payload[i] = (uint8_t)chance(256);
    }
    is_sound = receive(kind, number, payload, length);
    answer.kind = 0;
    while (pc.received_tail < pc.received_head)
        round_once();
    if (answer.kind == FRAME_RESET && answer.result == RESULT_TAKEN && frame[2] & RESET_POSITION)
        position = (int32_t)get32(frame + 3);
    LAW(pc.sent_length > sent || !is_sound);
    taken += answer.result == RESULT_TAKEN;
}

int main(int count, char **words)
{
    uint64_t many = count > 2 ? strtoull(words[2], NULL, 10) : 100000;

    seed = (count > 1 ? strtoull(words[1], NULL, 10) : 1) * 0x9E3779B97F4A7C15u + 1;
    pc.levels = INPUTS_MASK;
    power_up();
    for (frames = 0; frames < many; frames++) {
        send_one();
        check_laws();
        pc.sent_length = 0;
        pass(chance(8) ? chance(5000) : chance(8) ? chance(300000) : chance(100000000));
        if (!chance(5)) {
            pc.levels = (uint8_t)(chance(3) ? pc.levels ^ 1u << chance(INPUTS) : chance(64));
            look();
            check_laws();
        }
        round_once();
        check_laws();
    }
    printf("%" PRIu64 " frames, %" PRIu64 " taken, %" PRIu64 " steps, %" PRIu64 " of them with an edge, %" PRIu64
           " times on\n",
           frames, taken, steps, edges, times_on);
    return 0;
}
