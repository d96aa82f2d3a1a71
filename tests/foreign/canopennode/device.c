/* A CiA 406 encoder or a CiA 402 drive on CANopenNode, without a thread: the test hands it messages and time.
 *
 * CANopenNode does SDO, PDO, SYNC, EMCY, NMT and heartbeat. Here are the object dictionary, which every device
 * has for itself, and the state machine of a drive.
 */

#include <stdlib.h>

#define OD_DEFINITION
#include "301/CO_driver.h"
#include "301/CO_ODinterface.h"
#include "301/CO_Emergency.h"
#include "301/CO_HBconsumer.h"
#include "301/CO_NMT_Heartbeat.h"
#include "301/CO_PDO.h"
#include "301/CO_SDOserver.h"
#include "301/CO_SYNC.h"

enum { RX_NMT, RX_SYNC, RX_SDO, RX_RPDO, RX_HEARTBEATS, RX_COUNT = RX_HEARTBEATS + 2 };
enum { TX_HEARTBEAT, TX_SYNC, TX_SDO, TX_EMCY, TX_TPDO_1, TX_TPDO_2, TX_COUNT };
enum { OBJECTS = 40, VALUES = 120, ERRORS = 8, MAPPED = 8, TPDOS = 2, SDO_TIMEOUT_MS = 500 };
enum { SWITCH_ON_DISABLED = 0x0240, READY = 0x0221, SWITCHED_ON = 0x0223, ENABLED = 0x0227 };
enum { QUICK_STOP_ACTIVE = 0x0207, FAULT = 0x0208, FAULT_RESET = 0x80, PROFILE_VELOCITY = 3, STOP_QUICKLY = 3 };

static const char NAME[] = "device on CANopenNode";

typedef struct {
    uint8_t node;
    bool is_drive;
    uint16_t control; /* control word that the drive has followed */
    CO_CANmodule_t can;
    CO_CANrx_t rx[RX_COUNT];
    CO_CANtx_t tx[TX_COUNT];
    CO_NMT_t nmt;
    CO_HBconsumer_t watchdog;
    CO_HBconsNode_t watched[RX_COUNT - RX_HEARTBEATS];
    CO_EM_t em;
    CO_EM_fifo_t errors[ERRORS + 1];
    CO_SYNC_t sync;
    CO_SDOserver_t sdo;
    CO_RPDO_t rpdo;
    CO_TPDO_t tpdo[TPDOS];
    OD_t od;
    OD_entry_t entries[OBJECTS + 1];
    OD_obj_var_t variables[OBJECTS];
    OD_obj_record_t records[VALUES];
    uint16_t firsts[OBJECTS]; /* place of each object's first value */
    OD_extension_t extensions[OBJECTS];
    uint32_t values[VALUES], defaults[VALUES];
    uint16_t count; /* of values */
} Device;

/* The driver of CANopenNode */

CO_ReturnError_t CO_CANrxBufferInit(CO_CANmodule_t *can, uint16_t index, uint16_t ident, uint16_t mask, bool_t rtr,
                                    void *object, void (*callback)(void *object, void *message))
{
    (void)rtr;
    if (can == NULL || index >= can->rxSize) return CO_ERROR_ILLEGAL_ARGUMENT;
    can->rxArray[index] = (CO_CANrx_t){ident, mask, object, callback};
    return CO_ERROR_NO;
}

CO_CANtx_t *CO_CANtxBufferInit(CO_CANmodule_t *can, uint16_t index, uint16_t ident, bool_t rtr, uint8_t length,
                               bool_t syncFlag)
{
    (void)rtr;
    if (can == NULL || index >= can->txSize) return NULL;
    can->txArray[index] = (CO_CANtx_t){.ident = ident, .DLC = length, .syncFlag = syncFlag};
    return &can->txArray[index];
}

CO_ReturnError_t CO_CANsend(CO_CANmodule_t *can, CO_CANtx_t *buffer)
{
    can->send(buffer->ident, buffer->DLC, buffer->data);
    return CO_ERROR_NO;
}

void CO_CANclearPendingSyncPDOs(CO_CANmodule_t *can) { (void)can; }
void CO_CANmodule_process(CO_CANmodule_t *can) { (void)can; }

/* The object dictionary */

static uint32_t read_value(const OD_entry_t *entry, uint8_t sub)
{
    OD_IO_t io;
    OD_size_t count = 0;
    uint32_t value = 0;
    if (OD_getSub(entry, sub, &io, false) == ODR_OK && io.stream.dataLength <= sizeof value)
        io.read(&io.stream, &value, sizeof value, &count);
    return value;
}

uint32_t device_get(Device *d, uint16_t index, uint8_t sub) { return read_value(OD_find(&d->od, index), sub); }

void device_put(Device *d, uint16_t index, uint8_t sub, uint32_t value)
{
    OD_entry_t *entry = OD_find(&d->od, index);
    OD_IO_t io;
    OD_size_t count;
    if (OD_getSub(entry, sub, &io, false) != ODR_OK || read_value(entry, sub) == value) return;
    io.write(&io.stream, &value, io.stream.dataLength, &count);
    /* What OD_requestTPDO does, whose first argument is not the same in v4.0 and in 2026. */
    if (entry->extension != NULL) entry->extension->flagsPDO[sub / 8] &= ~(1 << sub % 8);
}

static void add(Device *d, uint16_t index, uint8_t sub, uint8_t size, OD_attr_t attribute, uint32_t value)
{
    uint32_t *place = &d->values[d->count];
    *place = d->defaults[d->count] = value;
    if (sub == 0) {
        OD_entry_t *entry = &d->entries[d->od.size];
        d->variables[d->od.size] = (OD_obj_var_t){.dataOrig = place, .attribute = attribute, .dataLength = size};
        *entry = (OD_entry_t){.index = index, .subEntriesCount = 1, .odObjectType = ODT_VAR};
        entry->odObject = &d->variables[d->od.size];
        d->firsts[d->od.size++] = d->count;
    } else {
        OD_entry_t *entry = &d->entries[d->od.size - 1];
        entry->odObjectType = ODT_REC;
        entry->subEntriesCount = sub + 1;
        entry->odObject = &d->records[d->firsts[d->od.size - 1]];
    }
    d->records[d->count++] =
        (OD_obj_record_t){.dataOrig = place, .subIndex = sub, .attribute = attribute, .dataLength = size};
}

static void extend(Device *d, ODR_t (*write)(OD_stream_t *, const void *, OD_size_t, OD_size_t *))
{
    OD_extension_t *extension = &d->extensions[d->od.size - 1];
    *extension = (OD_extension_t){.read = OD_readOriginal, .write = write};
    OD_extension_init(&d->entries[d->od.size - 1], extension);
}

/* An object whose change sends the TPDO that maps it. */
static void add_event(Device *d, uint16_t index, uint8_t size, uint32_t value)
{
    add(d, index, 0, size, ODA_SDO_R | ODA_TPDO, value);
    extend(d, OD_writeOriginal);
}

static ODR_t write_mode(OD_stream_t *stream, const void *data, OD_size_t count, OD_size_t *written)
{
    int8_t mode = *(const int8_t *)data;
    if (mode != 0 && mode != PROFILE_VELOCITY) return ODR_INVALID_VALUE;
    return OD_writeOriginal(stream, data, count, written);
}

static void add_pdo_communication(Device *d, uint16_t index, uint32_t cob_id, uint8_t kind)
{
    const uint8_t sizes[] = {1, 4, 1, 2, 1, 2};
    const uint32_t values[] = {5, cob_id, kind, 0, 0, 0};
    for (uint8_t sub = 0; sub < 6; sub++)
        add(d, index, sub, sizes[sub], sub == 0 ? ODA_SDO_R : ODA_SDO_RW, values[sub]);
}

static void add_pdo_mapping(Device *d, uint16_t index, const uint32_t *entries)
{
    uint8_t count = 0;
    while (count < MAPPED && entries[count] != 0) count++;
    add(d, index, 0, 1, ODA_SDO_RW, count);
    for (uint8_t sub = 1; sub <= MAPPED; sub++) add(d, index, sub, 4, ODA_SDO_RW, entries[sub - 1]);
}

/* `tpdo` and `rpdo` are what TPDO1 and RPDO1 map, then 0; TPDO1 is switched off where it maps nothing. */
static void describe(Device *d, uint8_t kind, const uint32_t *tpdo, const uint32_t *rpdo)
{
    const uint32_t nothing[MAPPED] = {0};
    const uint32_t off = 0x80000000;
    add(d, 0x1000, 0, 4, ODA_SDO_R, d->is_drive ? 0x00020192 : 0x00020196);
    add(d, 0x1001, 0, 1, ODA_SDO_R | ODA_TPDO, 0);
    for (uint8_t sub = 0; sub <= ERRORS; sub++) add(d, 0x1003, sub, sub ? 4 : 1, sub ? ODA_SDO_R : ODA_SDO_RW, 0);
    add(d, 0x1005, 0, 4, ODA_SDO_RW, 0x80);
    add(d, 0x1006, 0, 4, ODA_SDO_RW, 0);
    add(d, 0x1008, 0, 0, ODA_SDO_R | ODA_STR, 0);
    d->variables[d->od.size - 1].dataOrig = (void *)NAME;
    d->variables[d->od.size - 1].dataLength = sizeof NAME - 1;
    add(d, 0x1014, 0, 4, ODA_SDO_RW, 0x80 + d->node);
    add(d, 0x1016, 0, 1, ODA_SDO_R, 2);
    for (uint8_t sub = 1; sub <= 2; sub++) add(d, 0x1016, sub, 4, ODA_SDO_RW, 0);
    add(d, 0x1017, 0, 2, ODA_SDO_RW, 0);
    add(d, 0x1018, 0, 1, ODA_SDO_R, 4);
    for (uint8_t sub = 1; sub <= 4; sub++) add(d, 0x1018, sub, 4, ODA_SDO_R, 0x300 + sub);
    add(d, 0x1019, 0, 1, ODA_SDO_RW, 0);
    if (d->is_drive) {
        add_pdo_communication(d, 0x1400, 0x200 + d->node, 255);
        add_pdo_mapping(d, 0x1600, rpdo);
    }
    add_pdo_communication(d, 0x1800, (tpdo[0] ? 0 : off) | (0x180 + d->node), kind);
    add_pdo_communication(d, 0x1801, off | (0x280 + d->node), 1);
    add_pdo_mapping(d, 0x1A00, tpdo);
    add_pdo_mapping(d, 0x1A01, nothing);
    if (!d->is_drive) {
        add(d, 0x6000, 0, 2, ODA_SDO_RW, 0);
        add_event(d, 0x6004, 4, 0);
        add(d, 0x6500, 0, 2, ODA_SDO_R, 0);
        add(d, 0x6501, 0, 4, ODA_SDO_R, 40000);
        for (uint16_t index = 0x6503; index <= 0x6506; index++) add(d, index, 0, 2, ODA_SDO_R, 0);
        return;
    }
    add(d, 0x6007, 0, 2, ODA_SDO_RW, 1);
    add(d, 0x603F, 0, 2, ODA_SDO_R | ODA_TPDO, 0);
    add(d, 0x6040, 0, 2, ODA_SDO_RW | ODA_RPDO, 0);
    add_event(d, 0x6041, 2, SWITCH_ON_DISABLED);
    add(d, 0x6060, 0, 1, ODA_SDO_RW | ODA_RPDO, 0);
    extend(d, write_mode);
    add_event(d, 0x6061, 1, 0);
    add(d, 0x60FF, 0, 4, ODA_SDO_RW | ODA_RPDO, 0);
    add(d, 0x6502, 0, 4, ODA_SDO_R, 1 << (PROFILE_VELOCITY - 1));
}

/* The device */

static void restart(Device *d, bool everything)
{
    CO_CANmodule_t *can = &d->can;
    OD_t *od = &d->od;
    for (uint16_t number = 0; number < od->size; number++)
        for (uint8_t sub = 0; sub < od->list[number].subEntriesCount; sub++)
            if (everything || od->list[number].index < 0x2000)
                d->values[d->firsts[number] + sub] = d->defaults[d->firsts[number] + sub];
    if (everything) d->control = 0;
    CO_EM_init(&d->em, can, OD_find(od, 0x1001), d->errors, ERRORS + 1, OD_find(od, 0x1014), TX_EMCY,
               OD_find(od, 0x1003), d->node, NULL);
    CO_NMT_init(&d->nmt, OD_find(od, 0x1017), &d->em, d->node, 0, 0, can, RX_NMT, CO_CAN_ID_NMT_SERVICE, can,
                TX_HEARTBEAT, CO_CAN_ID_HEARTBEAT + d->node, NULL);
    memset(d->watched, 0, sizeof d->watched);
    CO_HBconsumer_init(&d->watchdog, &d->em, d->watched, RX_COUNT - RX_HEARTBEATS, OD_find(od, 0x1016), can,
                       RX_HEARTBEATS, NULL);
    CO_SYNC_init(&d->sync, &d->em, OD_find(od, 0x1005), OD_find(od, 0x1006), NULL, OD_find(od, 0x1019), can, RX_SYNC,
                 can, TX_SYNC, NULL);
    CO_SDOserver_init(&d->sdo, od, NULL, d->node, SDO_TIMEOUT_MS, can, RX_SDO, can, TX_SDO, NULL);
    if (d->is_drive)
        CO_RPDO_init(&d->rpdo, od, &d->em, &d->sync, CO_CAN_ID_RPDO_1 + d->node, OD_find(od, 0x1400),
                     OD_find(od, 0x1600), can, RX_RPDO, NULL);
    for (int number = 0; number < TPDOS; number++)
        CO_TPDO_init(&d->tpdo[number], od, &d->em, &d->sync, CO_CAN_ID_TPDO_1 + 0x100 * number + d->node,
                     OD_find(od, 0x1800 + number), OD_find(od, 0x1A00 + number), can, TX_TPDO_1 + number, NULL);
}

/* Report an error by EMCY; code 0 says that it has gone. */
void device_error(Device *d, uint16_t code)
{
    device_put(d, 0x603F, 0, code);
    CO_error(&d->em, code != 0, CO_EM_GENERIC_ERROR, code, 0);
}

/* Follow the control word, CiA 402-2 figure 9, and 6007h where the heartbeat of 1016h is lost. */
static void follow_control_word(Device *d)
{
    uint16_t word = device_get(d, 0x6040, 0), status = device_get(d, 0x6041, 0);
    bool is_reset = word & ~d->control & FAULT_RESET;
    d->control = word;
    if (is_reset) device_error(d, 0);
    if (status == FAULT)
        status = is_reset ? SWITCH_ON_DISABLED : FAULT;
    else if (!(word & 0x02))
        status = SWITCH_ON_DISABLED;
    else if (!(word & 0x04))
        status = status == ENABLED || status == QUICK_STOP_ACTIVE ? QUICK_STOP_ACTIVE : SWITCH_ON_DISABLED;
    else if ((word & 0x07) == 0x06)
        status = status == QUICK_STOP_ACTIVE ? status : READY;
    else if ((word & 0x0F) == 0x07 && (status == READY || status == ENABLED))
        status = SWITCHED_ON;
    else if ((word & 0x0F) == 0x0F && (status == READY || status == SWITCHED_ON || status == QUICK_STOP_ACTIVE))
        status = ENABLED;
    bool is_alone = CO_isError(&d->em, CO_EM_HEARTBEAT_CONSUMER);
    if (is_alone && status == ENABLED && device_get(d, 0x6007, 0) == STOP_QUICKLY) status = QUICK_STOP_ACTIVE;
    device_put(d, 0x6041, 0, status);
    device_put(d, 0x6061, 0, device_get(d, 0x6060, 0));
}

Device *device_new(uint8_t node, bool is_drive, uint8_t kind, const uint32_t *tpdo, const uint32_t *rpdo,
                   void (*send)(uint32_t ident, uint8_t length, const uint8_t *data))
{
    Device *d = calloc(1, sizeof *d);
    if (d == NULL) return NULL;
    d->node = node;
    d->is_drive = is_drive;
    d->can = (CO_CANmodule_t){send, d->rx, RX_COUNT, d->tx, TX_COUNT, 0, true};
    d->od.list = d->entries;
    describe(d, kind, tpdo, rpdo);
    restart(d, true);
    return d;
}

void device_free(Device *d) { free(d); }

/* Restart as after a return of the power. */
void device_reset(Device *d) { restart(d, true); }

/* Refuse to write an object. */
void device_protect(Device *d, uint16_t index, uint8_t sub)
{
    OD_entry_t *entry = OD_find(&d->od, index);
    if (entry == NULL || sub >= entry->subEntriesCount) return;
    if (sub == 0) d->variables[entry - d->entries].attribute &= ~ODA_SDO_W;
    d->records[d->firsts[entry - d->entries] + sub].attribute &= ~ODA_SDO_W;
}

uint8_t device_state(Device *d) { return d->nmt.operatingState; }
void device_command(Device *d, uint8_t command) { CO_NMT_sendInternalCommand(&d->nmt, (CO_NMT_command_t)command); }

void device_process(Device *d, uint32_t microseconds)
{
    CO_NMT_internalState_t state;
    CO_NMT_reset_cmd_t reset = CO_NMT_process(&d->nmt, &state, microseconds, NULL);
    if (reset != CO_RESET_NOT) {
        restart(d, reset == CO_RESET_APP);
        CO_NMT_process(&d->nmt, &state, 0, NULL);
    }
    bool is_operational = state == CO_NMT_OPERATIONAL;
    bool is_awake = is_operational || state == CO_NMT_PRE_OPERATIONAL;
    CO_SDOserver_process(&d->sdo, is_awake, microseconds, NULL);
    CO_HBconsumer_process(&d->watchdog, is_awake, microseconds, NULL);
    CO_EM_process(&d->em, is_awake, microseconds, NULL);
    bool was_sync = CO_SYNC_process(&d->sync, is_awake, microseconds, NULL) == CO_SYNC_RX_TX;
    if (d->is_drive) {
        CO_RPDO_process(&d->rpdo, is_operational, was_sync);
        follow_control_word(d);
    }
    for (int number = 0; number < TPDOS; number++)
        CO_TPDO_process(&d->tpdo[number], microseconds, NULL, is_operational, was_sync);
}

void device_receive(Device *d, uint16_t ident, uint8_t length, const uint8_t *data)
{
    CO_CANrxMsg_t message = {.ident = ident, .DLC = length};
    memcpy(message.data, data, length < 8 ? length : 8);
    for (int number = 0; number < RX_COUNT; number++) {
        CO_CANrx_t *buffer = &d->rx[number];
        if (buffer->callback != NULL && ((ident ^ buffer->ident) & buffer->mask) == 0) {
            buffer->callback(buffer->object, &message);
            device_process(d, 0);
            return;
        }
    }
}
