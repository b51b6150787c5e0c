C     Stress by the deformation gradient: PROPS are G and lambda,
C     stress = (G (b - 1) + lambda ln J 1)/J, b = F F', J = det F.
C     It has no tangent, and does not look at STRESS and DSTRAN.
      SUBROUTINE UMAT(STRESS,STATEV,DDSDDE,SSE,SPD,SCD,
     1 RPL,DDSDDT,DRPLDE,DRPLDT,STRAN,DSTRAN,TIME,DTIME,TEMP,DTEMP,
     2 PREDEF,DPRED,CMNAME,NDI,NSHR,NTENS,NSTATV,PROPS,NPROPS,COORDS,
     3 DROT,PNEWDT,CELENT,DFGRD0,DFGRD1,NOEL,NPT,LAYER,KSPT,KSTEP,KINC)
      INCLUDE 'ABA_PARAM.INC'
      CHARACTER*80 CMNAME
      DIMENSION STRESS(NTENS),PROPS(NPROPS),DFGRD1(3,3),B(3,3)
      DET=0.D0
      DO 10 I=1,3
        J=MOD(I,3)+1
        K=MOD(J,3)+1
        DET=DET+DFGRD1(1,I)*(DFGRD1(2,J)*DFGRD1(3,K)
     1   -DFGRD1(2,K)*DFGRD1(3,J))
        DO 10 L=1,3
          B(I,L)=0.D0
          DO 10 M=1,3
            B(I,L)=B(I,L)+DFGRD1(I,M)*DFGRD1(L,M)
   10 CONTINUE
      DO 20 I=1,3
        STRESS(I)=(PROPS(1)*(B(I,I)-1.D0)+PROPS(2)*LOG(DET))/DET
   20 CONTINUE
      STRESS(4)=PROPS(1)*B(1,2)/DET
      STRESS(5)=PROPS(1)*B(1,3)/DET
      STRESS(6)=PROPS(1)*B(2,3)/DET
      RETURN
      END
