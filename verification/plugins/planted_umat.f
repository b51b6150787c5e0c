C     The fibre of fibre_umat.f with a stress that grows with volume
C     strain, and a fault by PROPS(4): 1 components 5 and 6 of the strain
C     exchanged, 2 tensor shear taken for gamma in DDSDDE, 3 DDSDDE
C     transposed, 4 the fibre turned by the transposed DROT.
      SUBROUTINE UMAT(STRESS,STATEV,DDSDDE,SSE,SPD,SCD,
     1 RPL,DDSDDT,DRPLDE,DRPLDT,STRAN,DSTRAN,TIME,DTIME,TEMP,DTEMP,
     2 PREDEF,DPRED,CMNAME,NDI,NSHR,NTENS,NSTATV,PROPS,NPROPS,COORDS,
     3 DROT,PNEWDT,CELENT,DFGRD0,DFGRD1,NOEL,NPT,LAYER,KSPT,KSTEP,KINC)
      INCLUDE 'aba_param.inc'
      CHARACTER*(*) CMNAME
      DIMENSION STRESS(NTENS),STATEV(NSTATV),DDSDDE(NTENS,NTENS),
     1 DDSDDT(NTENS),DRPLDE(NTENS),STRAN(NTENS),DSTRAN(NTENS),TIME(2),
     2 PREDEF(1),DPRED(1),PROPS(NPROPS),COORDS(3),DROT(3,3),
     3 DFGRD0(3,3),DFGRD1(3,3),FIBRE(6),TURN(3,3),E(6),
     2 START(6),C(6,6)
      IF(NTENS.NE.6.OR.NSTATV.LT.6) CALL XIT
      KIND=NINT(PROPS(4))
      DO 5 J=1,3
        DO 5 I=1,3
          TURN(I,J)=DROT(I,J)
          IF(KIND.EQ.4) TURN(I,J)=DROT(J,I)
    5 CONTINUE
      CALL ROTSIG(STATEV,TURN,FIBRE,1,NDI,NSHR)
      G=PROPS(1)/(2.D0*(1.D0+PROPS(2)))
      A=2.D0*G*PROPS(2)/(1.D0-2.D0*PROPS(2))
      DO 20 J=1,6
        STATEV(J)=FIBRE(J)
        DO 10 I=1,6
          DDSDDE(I,J)=PROPS(3)*FIBRE(I)*FIBRE(J)
          IF(I.LE.3.AND.J.LE.3) DDSDDE(I,J)=DDSDDE(I,J)+A
   10   CONTINUE
        DDSDDE(J,J)=DDSDDE(J,J)+G
        IF(J.LE.3) DDSDDE(J,J)=DDSDDE(J,J)+G
   20 CONTINUE
      DO 25 J=1,6
        E(J)=DSTRAN(J)
        START(J)=STRESS(J)
   25 CONTINUE
      IF(KIND.EQ.1) THEN
        E(5)=DSTRAN(6)
        E(6)=DSTRAN(5)
      END IF
      VOLUME=30.D0*(E(1)+E(2)+E(3))
      DO 30 I=1,6
        STRESS(I)=STRESS(I)*(1.D0+VOLUME)
        DO 30 J=1,6
          STRESS(I)=STRESS(I)+DDSDDE(I,J)*E(J)
   30 CONTINUE
      DO 40 J=1,6
        DO 40 I=1,6
          IF(J.LE.3) DDSDDE(I,J)=DDSDDE(I,J)+30.D0*START(I)
          IF(KIND.EQ.2.AND.J.GT.3) DDSDDE(I,J)=2.D0*DDSDDE(I,J)
          C(I,J)=DDSDDE(I,J)
   40 CONTINUE
      DO 50 J=1,6
        DO 50 I=1,6
          IF(KIND.EQ.3) DDSDDE(I,J)=C(J,I)
   50 CONTINUE
      RETURN
      END
