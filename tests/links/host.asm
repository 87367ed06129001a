; Says some lines to a module on COM1 and shows what it answers, as a host program of 1990 does: by the registers of the
; 8250 UART.  Assembled twice: as a DOS program (-DDOS) and as the boot sector of a PC (-DBOOT).
COM1    equ 0x3F8
LCR     equ COM1 + 3            ; line control
MCR     equ COM1 + 4            ; modem control
LSR     equ COM1 + 5            ; line status: bit 0 a character has come, bit 5 another one may go out
DIVISOR equ 12                  ; 115200 / 12: 9600 baud
FORMAT  equ 0x0E                ; 7 data bits, odd parity, 2 stop bits

        cpu 8086
        bits 16
%ifdef DOS
        org 0x100
%else
        org 0x7C00
        jmp 0:start
%endif

start:  cld
        xor ax, ax
%ifdef BOOT
        mov ds, ax
        mov ss, ax
        mov sp, 0x7C00
%endif
        mov dx, LCR
        mov al, 0x80
        out dx, al              ; the next two bytes are the divisor
        mov dx, COM1
        mov al, DIVISOR
        out dx, al
        inc dx
        xor al, al
        out dx, al
        mov dx, LCR
        mov al, FORMAT
        out dx, al
        mov dx, MCR
        mov al, 3               ; DTR and RTS
        out dx, al

        mov si, lines
say:    lodsb
        or al, al
        jz done
        mov bl, al
        mov dx, LSR
.busy:  in al, dx
        test al, 0x20
        jz .busy
        mov al, bl
        mov dx, COM1
        out dx, al
        cmp bl, 13
        jne say
hear:   mov dx, LSR             ; a line has gone out: the answer to it
.none:  in al, dx
        test al, 1
        jz .none
        mov dx, COM1
        in al, dx
        and al, 0x7F            ; seven bits
        mov bl, al
        call show
        cmp bl, 13
        jne hear
        mov al, 10
        call show
        jmp say

%ifdef DOS
show:   mov dl, al              ; to the standard output
        mov ah, 2
        int 0x21
        ret
done:   mov ax, 0x4C00
        int 0x21
%else
show:   out 0xE9, al            ; to the debug port of the emulator
        ret
done:   mov al, 0
        out 0xF4, al            ; the emulator ends, with status 1
        hlt
%endif

lines:  db "Po", 13, "S10", 13, "T100", 13, "R50", 13, "+1200", 13, "E", 13, "V1", 13, 0
%ifdef BOOT
        times 510 - ($ - $$) db 0
        dw 0xAA55
%endif
