#include "answers.h"
#include "bytes.h"
#include "config.h"
#include "hal.h"
#include "limits.h"
#include "line.h"
#include "outputs.h"
#include "queue.h"
#include "reflexes.h"
#include "state.h"

struct answer answer;
uint8_t wanted;

static uint8_t sent;        /* number of the next event to be sent */
static uint32_t last_heard; /* tick of the last valid frame */
static uint8_t is_silent;   /* no frame for longer than CONFIG allows */

__attribute__((noinline)) void settle(uint8_t result, uint32_t tick)
{
    answer.free = (uint8_t)(SLOTS - queued);
    answer.state = state;
    answer.events = next_event;
    answer.inputs = levels;
    answer.flags = power;
    answer.position = position_now();
    hal_leave();
    answer.result = result;
    answer.tick = tick;
    if (result != RESULT_DAMAGED) {
        last_heard = tick;
        is_silent = 0;
    }
    if (has_estop(answer.inputs)) /* last: a value needed after a call would have to be saved before steps resume */
        answer.flags |= POWER_ESTOP;
}

void refuse(uint8_t result)
{
    settle(result, hal_enter());
}

uint8_t is_host_silent(uint32_t tick)
{
    if (config.watchdog && tick - last_heard >= config.watchdog)
        is_silent = 1;
    return is_silent;
}

void send_event(uint8_t number, const struct event *event)
{
    uint8_t payload[] = {event->kind, event->which, event->state, event->inputs, 0, 0, 0, 0, 0, 0, 0, 0};

    put32(put32(payload + 4, (uint32_t)event->position), event->tick);
    send(number, FRAME_EVENT, payload, sizeof payload);
}

/* Send events, in order, up to the one with this number. */
static void send_events_before(uint8_t number)
{
    for (;;) {
        struct event event;
        uint8_t next = next_event;

        if ((uint8_t)(next - sent) <= (uint8_t)(next - number))
            return; /* relative to the next one, because a self-test may have caused many */
        fetch_event(sent, &event);
        if ((uint8_t)(next_event - sent) > EVENTS_KEPT) {
            sent = (uint8_t)(next_event - EVENTS_KEPT); /* overwritten; the host sees the gap */
            continue;
        }
        send_event(sent, &event);
        sent++;
    }
}

void send_events(void)
{
    send_events_before(next_event);
}

static void send_ident(void)
{
    uint8_t payload[] = {VERSION, BOARD_NUMBER, SLOTS, TAIL_MOST, ROOM, 0, 0, 0, 0, 0, 0};

    put32(put16(payload + 5, SHORTEST), HZ);
    send(wanted, FRAME_IDENT, payload, sizeof payload);
}

void send_answer(void)
{
    uint8_t payload[] = {answer.echo,   answer.kind,   answer.result, answer.free, answer.state, answer.events,
                         answer.inputs, answer.flags, 0,             0,           0,            0,
                         0,             0,             0,             0};

    send_events_before(answer.events);
    if (answer.kind == FRAME_HELLO && answer.result == RESULT_TAKEN)
        send_ident();
    put32(put32(payload + 8, (uint32_t)answer.position), answer.tick);
    send(wanted, FRAME_ANSWER, payload, sizeof payload);
}
