; A host program of 1990 for an interface board: it asks a chipset for its version, and writes what it has read.
; Port 342h is the command register of the board, 340h its data, bit 7 of 344h is HostRdy.
; nasm -DDOS: a DOS program, which writes to its standard output; -DBOOT: a boot sector, to the debug port of QEMU.
bits 16
%ifdef DOS
org 0x100
%else
org 0x7c00
        xor ax, ax
        mov ds, ax
        mov ss, ax
        mov sp, 0x7c00
%endif

        call ready
        mov dx, 0x342
        mov al, 0x6c            ; GET_VRSN
        out dx, al
        call byte_in
        call show
        call byte_in
        call show
%ifdef DOS
        mov ax, 0x4c00
        int 0x21
%else
        mov dx, 0xf4            ; isa-debug-exit: status 1
        xor al, al
        out dx, al
stop:   hlt
        jmp stop
%endif

ready:  mov dx, 0x344
.again: in al, dx
        test al, 0x80
        jz .again
        ret

byte_in:
        call ready
        mov dx, 0x340
        in al, dx
        ret

show:   push ax                 ; two hexadecimal digits
        shr al, 4
        call digit
        pop ax
        and al, 0x0f
digit:  add al, '0'
        cmp al, '9'
        jbe .out
        add al, 'a' - '0' - 10
.out:
%ifdef DOS
        mov dl, al
        mov ah, 2
        int 0x21
%else
        mov dx, 0xe9
        out dx, al
%endif
        ret

%ifdef BOOT
times 510 - ($ - $$) db 0
dw 0xaa55
%endif
