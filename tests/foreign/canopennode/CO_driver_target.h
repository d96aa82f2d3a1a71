/* What CANopenNode asks of its target: types, and CAN messages that the test carries in and out. */

#ifndef CO_DRIVER_TARGET_H
#define CO_DRIVER_TARGET_H

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

#define CO_LITTLE_ENDIAN
#define CO_SWAP_16(x) x
#define CO_SWAP_32(x) x
#define CO_SWAP_64(x) x

typedef uint_fast8_t bool_t;
typedef float float32_t;
typedef double float64_t;

typedef struct {
    uint16_t ident;
    uint8_t DLC;
    uint8_t data[8];
} CO_CANrxMsg_t;

#define CO_CANrxMsg_readIdent(msg) (((CO_CANrxMsg_t *)(msg))->ident)
#define CO_CANrxMsg_readDLC(msg) (((CO_CANrxMsg_t *)(msg))->DLC)
#define CO_CANrxMsg_readData(msg) (((CO_CANrxMsg_t *)(msg))->data)

typedef struct {
    uint16_t ident, mask;
    void *object;
    void (*callback)(void *object, void *message);
} CO_CANrx_t;

typedef struct {
    uint32_t ident;
    uint8_t DLC;
    uint8_t data[8];
    volatile bool_t bufferFull, syncFlag;
} CO_CANtx_t;

typedef struct {
    void (*send)(uint32_t ident, uint8_t length, const uint8_t *data);
    CO_CANrx_t *rxArray;
    uint16_t rxSize;
    CO_CANtx_t *txArray;
    uint16_t txSize;
    uint16_t CANerrorStatus;
    volatile bool_t CANnormal;
} CO_CANmodule_t;

/* All of a PDO but deadlines of RPDOs, with which CO_RPDO_process has other arguments in v4.1 than in 2026. */
#define CO_CONFIG_PDO                                                                                                  \
    (CO_CONFIG_RPDO_ENABLE | CO_CONFIG_TPDO_ENABLE | CO_CONFIG_TPDO_TIMERS_ENABLE | CO_CONFIG_PDO_SYNC_ENABLE          \
     | CO_CONFIG_PDO_OD_IO_ACCESS | CO_CONFIG_FLAG_OD_DYNAMIC)

/* One thread does everything. */
#define CO_LOCK_CAN_SEND(CAN_MODULE)
#define CO_UNLOCK_CAN_SEND(CAN_MODULE)
#define CO_LOCK_EMCY(CAN_MODULE)
#define CO_UNLOCK_EMCY(CAN_MODULE)
#define CO_LOCK_OD(CAN_MODULE)
#define CO_UNLOCK_OD(CAN_MODULE)
#define CO_FLAG_READ(flag) ((flag) != NULL)
#define CO_FLAG_SET(flag) ((flag) = (void *)1L)
#define CO_FLAG_CLEAR(flag) ((flag) = NULL)

#endif
